#pragma once

#include <cstdint>
#include <exception>
#include <functional>

#include "track/tracked_frame.hpp"

namespace holdfast::app {

/// Parts of a run over frames; each is called from one thread only, track() from the caller's.
struct PipelineParts {
  std::function<bool(Frame&)> next;               ///< false at the end
  std::function<void(TrackedFrame&)> track;       ///< fills result, and mask where pictured
  std::function<bool(std::int64_t)> is_pictured;  ///< by ordinal: does write() need the picture?
  std::function<void(TrackedFrame&)> write;
  std::function<bool()> is_interrupted;  ///< asked before each frame
  bool live = false;                     ///< a frame that nobody took in time gives way to a newer one
};

/// Seconds, of which the parts' are busy, not waiting.
struct PartTimes {
  double wall_s = 0;
  double read_s = 0;
  double track_s = 0;
  double write_s = 0;
};

struct PipelineReport : PartTimes {
  std::int64_t frames = 0;  ///< written
  bool interrupted = false;
  std::exception_ptr failure;  ///< what ended the run early
  PartTimes first;             ///< of these, until the first frame was done: it makes what later ones use
};

/// Reads, tracks and writes in three threads, so that a run takes as long as its slowest part. Buffers are made once
/// and go round; they bound how far one part runs ahead. What a part throws ends the run and is reported, after the
/// frames before it were tracked and written where that can be done.
PipelineReport run_pipeline(const PipelineParts& parts);

}  // namespace holdfast::app
