#pragma once

#include <memory>
#include <opencv2/videoio.hpp>
#include <string>

namespace holdfast::app {

/// What the program calls of OpenCV's videoio. It brings a hundred libraries, FFmpeg among them, whose loading is a
/// good part of the program's start; pictures do without. What these return has virtual functions: call no others.
struct VideoModule {
  /// A file or URL, by FFmpeg where OpenCV has it; null when it is no video that can be decoded.
  std::unique_ptr<cv::VideoCapture> (*open_file)(const std::string& path);
  /// Null when there is no such camera, or it is in use.
  std::unique_ptr<cv::VideoCapture> (*open_camera)(int number);
  /// `codec`: four letters. Null when there is no encoder for it, or the file cannot be written.
  std::unique_ptr<cv::VideoWriter> (*create)(const std::string& path, const std::string& codec, double frame_rate,
                                             cv::Size size);
};

/// Throws Error(file) when it cannot be loaded.
const VideoModule& video_module();

}  // namespace holdfast::app
