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

std::vector<std::string> codecs_for(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".mp4" || extension == ".mov") {
    return {"avc1", "mp4v"};
  }
  if (extension == ".mkv") {
    return {"H264", "mp4v"};
  }
  if (extension == ".avi") {
    return {"MJPG"};
  }
  throw Error(
      ErrorCode::output,
      fmt::format("cannot write '{}': the name of a video must end in .mp4, .mov, .mkv or .avi", path.string()));
}

}  // namespace

OverlayVideo::OverlayVideo(const std::filesystem::path& path, cv::Size size, double frame_rate) : path_(path) {
  const std::vector<std::string> codecs = codecs_for(path);
  require_writable(path);
  const VideoModule& video = video_module();
  for (const std::string& codec : codecs) {
    writer_ = video.create(part_of(path).string(), codec, std::clamp(frame_rate, 1.0, 240.0), size);
    if (writer_) {
      return;
    }
  }
  throw Error(ErrorCode::output,
              fmt::format("cannot write '{}': no encoder for {}x{} pixels; OpenCV was built without FFmpeg, or the "
                          "disk is full",
                          path.string(), size.width, size.height));
}

void OverlayVideo::write(const cv::Mat& picture) { writer_->write(picture); }

OverlayVideo::~OverlayVideo() {
  if (!writer_) return;
  writer_->release();
  std::error_code ignored;
  std::filesystem::remove(part_of(path_), ignored);
}

void OverlayVideo::finish() {
  writer_->release();
  if (const auto damage = video_damage(part_of(path_))) {
    throw Error(ErrorCode::output,
                fmt::format("the video '{}' could not be completed, is the disk full? {}", path_.string(), *damage));
  }
  writer_.reset();
  put_in_place(path_);
}

}  // namespace holdfast::app
