#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/estimated_poses.hpp"
#include "holdfast/pose.hpp"
#include "video/frame_source.hpp"

namespace holdfast::app {

/// Frames with their poses: the inputs, or those of the one input that have one.
class PosedFrames {
 public:
  /// Throws Error(pose, image, file) where poses or inputs cannot be read, or several inputs have not a pose each.
  PosedFrames(const std::vector<std::string>& inputs, const std::filesystem::path& poses,
              const FrameSourceOptions& options);

  cv::Size size() const { return source_->size(); }
  std::int64_t count() const { return static_cast<std::int64_t>(poses_.entries.size()); }

  /// False at the end. Throws Error(image) where an input has another size.
  bool next(Frame& frame, Pose& T_camera_object);

 private:
  bool next_of_one(Frame& frame, Pose& T_camera_object);
  bool next_input(Frame& frame, Pose& T_camera_object);

  std::vector<std::string> inputs_;
  evaluation::EstimatedPoses poses_;
  std::optional<FrameSource> source_;
  std::size_t entry_ = 0;
};

}  // namespace holdfast::app
