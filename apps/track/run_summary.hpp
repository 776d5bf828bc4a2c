#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "track/pipeline.hpp"
#include "track/tracked_frame.hpp"

namespace holdfast::app {

/// A stretch of successive frames.
struct FrameRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// What a run came to.
struct RunSummary {
  std::int64_t frames = 0;
  std::int64_t held = 0;
  std::int64_t lost = 0;
  std::int64_t held_by_contour = 0;          ///< of those held
  std::optional<std::int64_t> texture_left;  ///< first frame without the texture, where frames do not show the model's
  std::vector<FrameRange> lost_ranges;
  std::string first_loss_reason;
  bool complete = false;  ///< the input was followed to its end
  double median_ms = 0;   ///< of tracking, frames held
  double median_lost_ms = 0;
  bool texture_asked = false;  ///< in a frame at least
  bool by_texture = true;      ///< of the frames held, at least half are held by their texture
  /// Of these, intensity in [0, 1]; where most are held without it, of the contour, pixels; 0: none held.
  double median_residual = 0;
  double median_used_pixels = 0;  ///< of the same frames; of the contour, lines across it
  double frames_per_second = 0;   ///< this and the following: after the first frame, where there are more
  StageTimes mean_ms;             ///< of tracking
  double read_ms = 0;             ///< mean a frame, busy time of the other two parts
  double track_ms = 0;            ///< of this one, with all around the tracker
  double write_ms = 0;
};

/// The median of any number of values in bounded memory: of all up to kMost, of a random sample of kMost beyond.
class RunningMedian {
 public:
  static constexpr std::size_t kMost = 8192;

  void add(double value);
  std::size_t kept() const { return sample_.size(); }
  double value() const;  ///< 0 of none

 private:
  std::vector<double> sample_;
  std::uint64_t added_ = 0;
  std::minstd_rand random_;  // the same numbers in every run
};

/// Gathers the figures of frame after frame.
class SummaryBuilder {
 public:
  void add(const TrackedFrame& tracked);
  RunSummary summary(const PipelineReport& report) const;

 private:
  RunSummary counts_;
  StageTimes total_ms_;
  bool last_was_lost_ = false;
  RunningMedian held_ms_;
  RunningMedian lost_ms_;
  /// Of the frames held, in units of their own.
  struct Fit {
    RunningMedian residual;
    RunningMedian used;
  };
  Fit by_texture_;
  Fit without_texture_;
};

/// The summary in a few lines for people.
std::string summary_text(const RunSummary& summary);

}  // namespace holdfast::app
