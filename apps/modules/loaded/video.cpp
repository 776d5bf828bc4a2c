#include <opencv2/videoio/registry.hpp>

#include "holdfast/export.hpp"
#include "modules/video_module.hpp"

namespace holdfast::app {
namespace {

std::unique_ptr<cv::VideoCapture> open_file(const std::string& path) {
  const bool has_ffmpeg = cv::videoio_registry::hasBackend(cv::CAP_FFMPEG);
  auto capture = std::make_unique<cv::VideoCapture>();
  return capture->open(path, has_ffmpeg ? cv::CAP_FFMPEG : cv::CAP_ANY) ? std::move(capture) : nullptr;
}

std::unique_ptr<cv::VideoCapture> open_camera(int number) {
  auto capture = std::make_unique<cv::VideoCapture>();
  return capture->open(number, cv::CAP_V4L2) ? std::move(capture) : nullptr;
}

std::unique_ptr<cv::VideoWriter> create(const std::string& path, const std::string& codec, double frame_rate,
                                        cv::Size size) {
  const int fourcc = cv::VideoWriter::fourcc(codec.at(0), codec.at(1), codec.at(2), codec.at(3));
  auto writer = std::make_unique<cv::VideoWriter>();
  return writer->open(path, cv::CAP_FFMPEG, fourcc, frame_rate, size) ? std::move(writer) : nullptr;
}

}  // namespace
}  // namespace holdfast::app

extern "C" {
HOLDFAST_EXPORT extern const holdfast::app::VideoModule holdfast_video;
const holdfast::app::VideoModule holdfast_video{holdfast::app::open_file, holdfast::app::open_camera,
                                                holdfast::app::create};
}
