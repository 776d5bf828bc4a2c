#pragma once

#include <array>
#include <cstdint>
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
  std::vector<FrameRange> lost_ranges;
  std::string first_loss_reason;
  bool complete = false;          ///< the input was followed to its end
  double median_ms = 0;           ///< of tracking, all frames
  double median_residual = 0;     ///< of frames held; 0 where none was
  double median_used_pixels = 0;  ///< likewise
  double frames_per_second = 0;   ///< of the whole run
  StageTimes mean_ms;             ///< of tracking
  double read_ms = 0;             ///< mean a frame, busy time of the other two parts
  double track_ms = 0;            ///< of this one, with all around the tracker
  double write_ms = 0;
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
  std::vector<double> ms_;
  std::vector<double> residuals_;
  std::vector<double> used_pixels_;
};

/// The summary in a few lines for people.
std::string summary_text(const RunSummary& summary);

}  // namespace holdfast::app
