#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace holdfast::app {

struct FrameSourceOptions {
  std::int64_t start = 0;            ///< first frame delivered
  std::optional<std::int64_t> stop;  ///< first frame not delivered any more; nothing: to the end
  std::int64_t stride = 1;           ///< every stride-th frame
  double frame_rate = 0;             ///< frames a second of images, or instead of a video's own; 0: 30, or the video's
  int live_width = 0;                ///< size asked of a live camera, pixels; 0: its own choice
  int live_height = 0;
  /// Asked while a live camera delivers nothing: whether to wait no longer. None: the input ends then.
  std::function<bool()> gives_up;
};

struct Frame {
  cv::Mat image;           ///< BGR8
  std::int64_t index = 0;  ///< frame number in the input, counted without start and stride
  /// Seconds from the input's first frame, rising strictly: a video's own stamps, of a camera when the frame came.
  /// Where a video has none, or one that does not rise, and for images, the frame rate tells.
  double time_s = 0;
};

/// The frames of a video file, an image folder, an image pattern (printf or glob), or a live camera, as recorded:
/// rotation metadata is not applied, because a camera's calibration belongs to the recorded frames.
class FrameSource {
 public:
  /// Opens the input and reads its first frame. `input`: a path, a pattern, a URL, or a camera's number.
  /// Throws Error(file) for what is missing, unreadable or empty, Error(invalid_argument) for options out of range.
  explicit FrameSource(const std::string& input, const FrameSourceOptions& options = {});
  ~FrameSource();
  FrameSource(FrameSource&&) noexcept;
  FrameSource& operator=(FrameSource&&) noexcept;

  /// The next frame, a video's in the memory that `frame` brings; false at the end.
  /// Throws Error(file) for an image that cannot be read, Error(image) for a frame of another size than the first.
  bool next(Frame& frame);

  /// Size of every frame, pixels.
  cv::Size size() const;
  /// Frames that next() delivers in all, where the input tells.
  std::optional<std::int64_t> frame_count() const;
  /// Frames a second of the input (without stride).
  double frame_rate() const;
  /// Frames come as time passes, and are gone when nobody takes them.
  bool live() const;
  /// What is odd about the first frame, in one sentence, if anything is.
  std::optional<std::string> doubt() const;
  /// After next() returned false: why the input ended early, in one sentence.
  std::optional<std::string> ended_early() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace holdfast::app
