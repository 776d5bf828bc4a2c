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
  /// `frames`: how many are shown, if the run has as many; `expected`: frames of the run as its file announces them,
  /// which may be wrong.
  /// Throws Error(output) when the file cannot be written, Error(invalid_argument) for a count under 1.
  ContactSheet(const std::filesystem::path& path, int frames, std::optional<std::int64_t> expected);

  /// Which frames add() should be given: more than will be shown, farther apart the longer the run, because it may end
  /// before or after what was announced.
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

  std::int64_t step_at(std::int64_t ordinal) const;

  std::filesystem::path path_;
  std::int64_t frames_;
  std::int64_t first_step_;
  std::vector<Tile> tiles_;
};

}  // namespace holdfast::app
