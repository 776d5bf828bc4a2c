#include "track/overlay_video.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "holdfast/error.hpp"
#include "track/output_file.hpp"
#include "video/media_check.hpp"

namespace holdfast::app {
namespace {

std::vector<int> codecs_for(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  const int h264 = cv::VideoWriter::fourcc('a', 'v', 'c', '1');
  const int h264_in_mkv = cv::VideoWriter::fourcc('H', '2', '6', '4');
  const int mpeg4 = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  if (extension == ".mp4" || extension == ".mov") {
    return {h264, mpeg4};
  }
  if (extension == ".mkv") {
    return {h264_in_mkv, mpeg4};
  }
  if (extension == ".avi") {
    return {cv::VideoWriter::fourcc('M', 'J', 'P', 'G')};
  }
  throw Error(
      ErrorCode::output,
      fmt::format("cannot write '{}': the name of a video must end in .mp4, .mov, .mkv or .avi", path.string()));
}

}  // namespace

OverlayVideo::OverlayVideo(const std::filesystem::path& path, cv::Size size, double frame_rate) : path_(path) {
  const std::vector<int> codecs = codecs_for(path);
  require_writable(path);
  for (const int codec : codecs) {
    if (writer_.open(path.string(), cv::CAP_FFMPEG, codec, std::clamp(frame_rate, 1.0, 240.0), size)) {
      return;
    }
  }
  throw Error(ErrorCode::output,
              fmt::format("cannot write '{}': no encoder for {}x{} pixels; OpenCV was built without FFmpeg, or the "
                          "disk is full",
                          path.string(), size.width, size.height));
}

void OverlayVideo::write(const cv::Mat& picture) { writer_.write(picture); }

void OverlayVideo::finish() {
  writer_.release();
  if (const auto damage = video_damage(path_)) {
    throw Error(ErrorCode::output,
                fmt::format("the video '{}' could not be completed, is the disk full? {}", path_.string(), *damage));
  }
}

}  // namespace holdfast::app
