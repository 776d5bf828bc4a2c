#include "evaluation/protocol.hpp"

#include <fmt/core.h>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {
namespace {

void check(std::span<const Pose> truth, std::span<const double> visible, const ProtocolOptions& options) {
  if (options.step < 1 || options.offset < 0 || options.offset >= options.step) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("frame step {} with offset {}: the step must be at least 1 and the offset below it",
                            options.step, options.offset));
  }
  if (static_cast<std::size_t>(options.offset) >= truth.size()) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("offset {} leaves none of the {} frames", options.offset, truth.size()));
  }
  if (!visible.empty() && visible.size() != truth.size()) {
    throw Error(ErrorCode::invalid_argument, fmt::format("{} visible shares for {} true poses: one a frame is needed",
                                                         visible.size(), truth.size()));
  }
}

/// Puts the tracker to the truth; false where it cannot start from there (the object out of view, say).
bool try_reset(const TrackerUnderTest& tracker, const Pose& T_camera_object) {
  try {
    tracker.reset(T_camera_object);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::pose) {
      throw;
    }
    return false;
  }
  return true;
}

}  // namespace

std::vector<FrameRecord> run_protocol(std::span<const Pose> truth, std::span<const double> visible,
                                      const TrackerUnderTest& tracker, const ProtocolOptions& options) {
  check(truth, visible, options);
  const bool resets = options.protocol == Protocol::rbot;
  const int frames = static_cast<int>(truth.size());

  int frame = options.offset;
  tracker.reset(truth[frame]);
  if (resets) {
    if (options.show_start_frame) {
      tracker.track(frame);
    }
    frame += options.step;
  }

  std::vector<FrameRecord> records;
  for (; frame < frames; frame += options.step) {
    FrameRecord record;
    record.frame = frame;
    record.step = options.step;
    record.offset = options.offset;
    record.T_camera_object_true = truth[frame];
    record.result = tracker.track(frame);
    record.error = pose_error(truth[frame], record.result.T_camera_object);
    record.visible = visible.empty() ? 1.0 : visible[frame];
    record.counted = record.visible >= options.minimum_visible;
    record.failed = record.counted && !options.failure.holds(record.error);
    if (tracker.inspect) {
      tracker.inspect(record);
    }
    // Where the truth cannot be started from, the next frame fails too and brings the next attempt.
    if (resets && record.failed && try_reset(tracker, truth[frame]) && options.show_start_frame) {
      tracker.track(frame);
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace holdfast::evaluation
