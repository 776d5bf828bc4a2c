#include "evaluation/protocol.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"

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

bool ended(const ProtocolOptions& options) { return options.is_interrupted && options.is_interrupted(); }

/// Puts the tracker to the truth; false where it cannot start from there (the object out of view, say).
bool try_reset(const TrackerUnderTest& tracker, const Pose& T_camera_object, int frame, bool show_frame) {
  try {
    if (show_frame && tracker.reset_on) {
      tracker.reset_on(T_camera_object, frame);
    } else {
      tracker.reset(T_camera_object);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::pose) {
      throw;
    }
    return false;
  }
  return true;
}

FrameRecord track_frame(std::span<const Pose> truth, std::span<const double> visible, const TrackerUnderTest& tracker,
                        const ProtocolOptions& options, int frame) {
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
  return record;
}

/// Uniform on the unit sphere.
Eigen::Vector3d direction(simulation::Random& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi);
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(angle), across * std::sin(angle), z};
}

Pose disturbed(const Pose& T_camera_object, const StartOptions& options, simulation::Random& random) {
  Pose out = T_camera_object;
  const double angle = options.rotation * random.uniform(), distance = options.translation * random.uniform();
  out.linear() = Eigen::AngleAxisd(angle, direction(random)) * out.linear();
  out.translation() += distance * direction(random);
  return out;
}

}  // namespace

std::vector<FrameRecord> run_protocol(std::span<const Pose> truth, std::span<const double> visible,
                                      const TrackerUnderTest& tracker, const ProtocolOptions& options) {
  check(truth, visible, options);
  const bool resets = options.protocol == Protocol::rbot;
  const int frames = static_cast<int>(truth.size());

  int frame = options.offset;
  const bool shows = resets && options.show_start_frame;
  if (shows && tracker.reset_on) {
    tracker.reset_on(truth[frame], frame);
  } else {
    tracker.reset(truth[frame]);
  }
  if (resets) frame += options.step;

  std::vector<FrameRecord> records;
  for (; frame < frames && !ended(options); frame += options.step) {
    FrameRecord record = track_frame(truth, visible, tracker, options, frame);
    if (tracker.inspect) {
      tracker.inspect(record);
    }
    // Where the truth cannot be started from, the next frame fails too and brings the next attempt.
    if (resets && record.failed) try_reset(tracker, truth[frame], frame, shows);
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<FrameRecord> run_starts(std::span<const Pose> truth, std::span<const double> visible,
                                    const TrackerUnderTest& tracker, const StartOptions& options,
                                    const ProtocolOptions& judged) {
  ProtocolOptions protocol = judged;
  check(truth, visible, protocol);
  const auto frames = static_cast<std::int64_t>(truth.size());
  if (options.frames < 1 || options.frames > frames || options.count < 1) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} starts with {} frames each: both must be at least 1, and {} frames is all there are",
                            options.count, options.frames, frames));
  }
  std::vector<FrameRecord> records;
  for (int start = 0; start < options.count && !ended(protocol); ++start) {
    simulation::Random random(options.seed, static_cast<std::uint64_t>(start));
    const int first = static_cast<int>(start * (frames - options.frames + 1) / options.count);
    tracker.reset(disturbed(truth[first], options, random));
    protocol.offset = start;
    for (int i = 0; i + 1 < options.frames; ++i) tracker.track(first + i);
    records.push_back(track_frame(truth, visible, tracker, protocol, first + options.frames - 1));
    if (tracker.inspect) {
      tracker.inspect(records.back());
    }
  }
  return records;
}

}  // namespace holdfast::evaluation
