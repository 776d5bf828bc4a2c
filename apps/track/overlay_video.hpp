#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

#include "modules/video_module.hpp"

namespace holdfast::app {

/// A video being written: .mp4 and .mkv with H.264 (MPEG-4 where there is no encoder for it), .avi with motion JPEG.
class OverlayVideo {
 public:
  /// Written beside its place under the name of part_of(): of one that is cut off .avi can be played, .mkv once its
  /// first seconds are written, .mp4 and .mov cannot. Throws Error(output) when the file cannot be written, or its name
  /// has another extension.
  OverlayVideo(const std::filesystem::path& path, cv::Size size, double frame_rate);
  ~OverlayVideo();
  OverlayVideo(const OverlayVideo&) = delete;
  OverlayVideo& operator=(const OverlayVideo&) = delete;

  /// A BGR8 picture of the size given.
  void write(const cv::Mat& picture);

  /// Completes the file and puts it in its place. Throws Error(output) when it turns out incomplete: encoders do not
  /// say when the disk is full.
  void finish();

 private:
  std::filesystem::path path_;
  std::unique_ptr<cv::VideoWriter> writer_;
};

}  // namespace holdfast::app
