#pragma once

#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "holdfast/image_view.hpp"

namespace holdfast {

/// Separable Gaussian and halving, the same for the rendered view and the frame.
class ImageFilter {
 public:
  /// Standard deviation of the Gaussian, pixels of every level: least error over boxes and bread. It reaches
  /// HF_BLUR_RADIUS (kernels/image/image_filter.cl has its weights).
  static constexpr double kSigma = 0.8;
  /// Pixels around an object that are blurred too: those that its pixels may be compared with, and their differences.
  static constexpr int kMargin = HF_BLUR_RADIUS + 4;

  explicit ImageFilter(const Device::Impl& device);

  /// `rect` in pixels of the coarser level.
  void enqueue_halve(const cl::Buffer& in, const Level& in_level, const Rect& rect, const Level& out_level,
                     const cl::Buffer& out);
  /// The same of a frame as it comes, where reads_frames().
  void enqueue_halve(const cl::Buffer& in, PixelFormat format, const kernel::hf_frame& frame, const Rect& rect,
                     const Level& out_level, const cl::Buffer& out);
  /// Blurs interleaved premultiplied pixels and divides by coverage. `rect` starts and is wide in whole vectors of four
  /// pixels; in `covered` coverage is known to be 1 everywhere.
  void enqueue_blur(const cl::Buffer& in, const Level& level, const Rect& rect, const cl::Buffer& out,
                    const Rect& covered = {});

  /// Whether frames of this format, as no lens distorts them, can be blurred and halved as they come, without being
  /// converted.
  bool reads_frames(PixelFormat format) const { return static_cast<std::size_t>(format) < blur_frame_.size(); }
  /// Blurs such a frame.
  void enqueue_blur(const cl::Buffer& in, PixelFormat format, const kernel::hf_frame& frame, const Level& level,
                    const Rect& rect, const cl::Buffer& out);

  /// Enqueues a kernel that blurs as it goes, an item (or a group) a block of `rect`.
  void enqueue_blocks(const cl::Kernel& kernel, const Rect& rect) const;

 private:
  const Device::Impl& device_;
  cl::Kernel halve_, blur_;
  std::vector<cl::Kernel> blur_frame_, halve_frame_;  ///< one a format
};

inline kernel::hf_rect to_kernel(const Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

}  // namespace holdfast
