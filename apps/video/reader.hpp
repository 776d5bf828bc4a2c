#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "video/frame_source.hpp"

namespace holdfast::app {

/// Of images, and of videos that do not tell theirs.
inline constexpr double kImageFrameRate = 30;
inline constexpr const char* kInputKinds =
    "the input is a video file, an image folder, a pattern such as frames/%06d.png, or a camera's number";

/// One kind of input, front to back.
class Reader {
 public:
  virtual ~Reader() = default;
  /// Moves on to a frame; false at the end. skip() of frames that nobody wants to see saves converting them.
  virtual bool read(Frame& frame) = 0;
  virtual bool skip() = 0;
  virtual std::int64_t first_index() const { return 0; }
  /// One past the last frame's index, where known, if only by an estimate.
  virtual std::optional<std::int64_t> end_index() const { return std::nullopt; }
  virtual bool end_is_certain() const { return true; }
  virtual double frame_rate() const = 0;
  virtual bool live() const { return false; }
  /// What the frame last read is called in messages.
  virtual std::string name_of_last() const = 0;
  /// By how many degrees to the right the frame last read is said to be turned to stand upright.
  virtual int turn() const { return 0; }
  /// A doubt that these are the frames that were meant.
  virtual std::optional<std::string> doubt() const { return std::nullopt; }
  /// Having come to the end after the frame before `index`: why that is too early.
  virtual std::optional<std::string> ended_early(std::int64_t) const { return std::nullopt; }
};

/// A video file or URL; `frame_rate` above 0 overrides its own. Throws Error(file).
std::unique_ptr<Reader> open_video(const std::string& path, double frame_rate);

}  // namespace holdfast::app
