#include "evaluation/pose_comparison.hpp"

#include <fmt/core.h>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {

std::vector<FrameRecord> compare_poses(const Sequence& sequence, const EstimatedPoses& estimates,
                                       const Tolerance& failure, double minimum_visible, bool partial) {
  const std::size_t frames = sequence.truth.size();
  if (!partial && estimates.entries.size() != frames) {
    throw Error(ErrorCode::file,
                fmt::format("{} estimated poses for the {} true poses of '{}': one a frame is needed, or --partial",
                            estimates.entries.size(), frames, sequence.name));
  }
  std::vector<FrameRecord> records;
  for (const EstimatedPoses::Entry& entry : estimates.entries) {
    if (entry.frame < 0 || static_cast<std::size_t>(entry.frame) >= frames) {
      throw Error(ErrorCode::file, fmt::format("an estimated pose of frame {}, but '{}' has the frames 0 to {}",
                                               entry.frame, sequence.name, frames - 1));
    }
    FrameRecord record;
    record.frame = entry.frame;
    record.T_camera_object_true = sequence.truth[entry.frame];
    record.result = entry.result;
    record.error = pose_error(record.T_camera_object_true, entry.result.T_camera_object);
    record.visible = sequence.visible.empty() ? 1.0 : sequence.visible[entry.frame];
    record.counted = record.visible >= minimum_visible;
    record.failed = record.counted && !failure.holds(record.error);
    records.push_back(record);
  }
  return records;
}

}  // namespace holdfast::evaluation
