#include "baking/posed_frames.hpp"

#include <fmt/format.h>

#include "holdfast/error.hpp"

namespace holdfast::app {

PosedFrames::PosedFrames(const std::vector<std::string>& inputs, const std::filesystem::path& poses,
                         const FrameSourceOptions& options)
    : inputs_(inputs) {
  if (inputs_.size() == 1) {
    source_.emplace(inputs_.front(), options);
    poses_ = evaluation::load_estimated_poses(poses, source_->frame_rate());
  } else {
    poses_ = evaluation::load_estimated_poses(poses, std::nullopt);
    if (poses_.entries.size() != inputs_.size()) {
      throw Error(ErrorCode::pose, fmt::format("'{}' has {} poses for {} inputs: give one pose for each",
                                               poses.string(), poses_.entries.size(), inputs_.size()));
    }
    source_.emplace(inputs_.front());
  }
}

bool PosedFrames::next(Frame& frame, Pose& T_camera_object) {
  return inputs_.size() == 1 ? next_of_one(frame, T_camera_object) : next_input(frame, T_camera_object);
}

bool PosedFrames::next_of_one(Frame& frame, Pose& T_camera_object) {
  while (source_->next(frame)) {
    while (entry_ < poses_.entries.size() && poses_.entries[entry_].frame < frame.index) {
      ++entry_;
    }
    if (entry_ == poses_.entries.size()) {
      return false;
    }
    const auto& entry = poses_.entries[entry_];
    if (entry.frame == frame.index && entry.held()) {
      T_camera_object = entry.result.T_camera_object;
      return true;
    }
  }
  return false;
}

bool PosedFrames::next_input(Frame& frame, Pose& T_camera_object) {
  while (entry_ < inputs_.size()) {
    const std::size_t i = entry_++;
    if (i > 0) {
      const cv::Size expected = source_->size();
      source_.emplace(inputs_[i]);
      if (source_->size() != expected) {
        throw Error(
            ErrorCode::image,
            fmt::format("'{}' has {}x{} pixels, the inputs before it {}x{}: all must come from one camera", inputs_[i],
                        source_->size().width, source_->size().height, expected.width, expected.height));
      }
    }
    if (poses_.entries[i].held() && source_->next(frame)) {
      T_camera_object = poses_.entries[i].result.T_camera_object;
      return true;
    }
  }
  return false;
}

}  // namespace holdfast::app
