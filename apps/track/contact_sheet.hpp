#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "track/tracked_frame.hpp"

namespace holdfast::app {

/// One picture of frames spread evenly over a run, each with its number and status.
class ContactSheet {
 public:
  /// `frames`: how many are shown at most; `expected`: frames of the run where known.
  /// Throws Error(output) when the file cannot be written, Error(invalid_argument) for a count under 1.
  ContactSheet(const std::filesystem::path& path, int frames, std::optional<std::int64_t> expected);

  /// Which frames add() should be given. Where the run's length is unknown these are more than will be shown, ever
  /// farther apart.
  bool wants(std::int64_t ordinal) const;

  /// `picture`: BGR8, all of one size.
  void add(const TrackedFrame& tracked, const cv::Mat& picture);

  /// Writes the file. Throws Error(output).
  void finish() const;

 private:
  struct Tile {
    std::int64_t ordinal = 0;
    cv::Mat picture;
  };

  std::filesystem::path path_;
  std::int64_t frames_;
  std::optional<std::int64_t> expected_;
  std::vector<Tile> tiles_;
};

}  // namespace holdfast::app
