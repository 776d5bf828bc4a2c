#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <opencv2/videoio.hpp>
#include <string>

#include "video/reader.hpp"

namespace holdfast::app {

/// A live camera. One that delivers nothing any more is opened again until it does, or until nobody waits for it.
class CameraReader : public Reader {
 public:
  using Open = std::function<std::unique_ptr<cv::VideoCapture>()>;

  /// `open`: null where it cannot be opened. `options`: size, frame rate, and who waits. Throws Error(file).
  CameraReader(int number, Open open, const FrameSourceOptions& options,
               std::chrono::milliseconds pause = std::chrono::milliseconds(500));

  bool read(Frame& frame) override;
  bool skip() override;
  double frame_rate() const override { return frame_rate_; }
  bool live() const override { return true; }
  std::string name_of_last() const override;
  std::optional<std::string> ended_early(std::int64_t index) const override;

 private:
  bool reopen();
  /// Calls take() on the camera until it succeeds, opening it again in between.
  bool taken(const std::function<bool(cv::VideoCapture&)>& take);

  int number_;
  Open open_;
  FrameSourceOptions options_;
  std::chrono::milliseconds pause_;
  std::unique_ptr<cv::VideoCapture> capture_;
  double frame_rate_ = 0;
  std::int64_t read_ = 0;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace holdfast::app
