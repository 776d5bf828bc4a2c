#include "video/camera_reader.hpp"

#include <fmt/format.h>

#include <thread>
#include <utility>

#include "holdfast/error.hpp"

namespace holdfast::app {

CameraReader::CameraReader(int number, Open open, const FrameSourceOptions& options, std::chrono::milliseconds pause)
    : number_(number), open_(std::move(open)), options_(options), pause_(pause) {
  if (!reopen()) {
    throw Error(ErrorCode::file,
                fmt::format("cannot open camera {}: is it connected (/dev/video{}), free, and are you allowed to use "
                            "it?",
                            number, number));
  }
  const double own_rate = capture_->get(cv::CAP_PROP_FPS);
  frame_rate_ = own_rate > 0 && own_rate < 1e4 ? own_rate : kImageFrameRate;
}

bool CameraReader::reopen() {
  capture_.reset();  // a device can be opened once
  capture_ = open_();
  if (!capture_) return false;
  if (options_.live_width > 0 && options_.live_height > 0) {
    capture_->set(cv::CAP_PROP_FRAME_WIDTH, options_.live_width);
    capture_->set(cv::CAP_PROP_FRAME_HEIGHT, options_.live_height);
  }
  if (options_.frame_rate > 0) capture_->set(cv::CAP_PROP_FPS, options_.frame_rate);
  return true;
}

bool CameraReader::taken(const std::function<bool(cv::VideoCapture&)>& take) {
  while (!capture_ || !take(*capture_)) {
    if (!options_.gives_up || options_.gives_up()) return false;
    std::this_thread::sleep_for(pause_);
    reopen();
  }
  if (read_ == 0) begin_ = std::chrono::steady_clock::now();
  return true;
}

bool CameraReader::read(Frame& frame) {
  const bool there =
      taken([&](cv::VideoCapture& capture) { return capture.read(frame.image) && !frame.image.empty(); });
  if (!there) return false;
  frame.index = read_++;
  frame.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  return true;
}

bool CameraReader::skip() {
  if (!taken([](cv::VideoCapture& capture) { return capture.grab(); })) return false;
  ++read_;
  return true;
}

std::string CameraReader::name_of_last() const { return fmt::format(" of camera {}", number_); }

std::optional<std::string> CameraReader::ended_early(std::int64_t) const {
  return fmt::format("camera {} delivers no more frames: was it disconnected?", number_);
}

}  // namespace holdfast::app
