#pragma once

#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "holdfast/image_view.hpp"

namespace holdfast {

/// Separable Gaussian and halving, the same for the rendered view and the frame.
class ImageFilter {
 public:
  /// `sigma` in pixels; 0 leaves images as they are. Throws Error(invalid_argument) when the reach exceeds
  /// HF_MAX_RADIUS.
  ImageFilter(const Device::Impl& device, double sigma);

  /// Pixels that images of every level are blurred by, and beyond which the blur does not reach.
  double sigma() const { return sigma_; }
  int radius() const { return radius_; }
  /// gaussian_taps() of that sigma.
  const cl::Buffer& taps() const { return taps_; }

  /// Weights of a one-dimensional Gaussian: [0] the centre, then one side; they sum to one over both sides.
  static std::vector<float> gaussian_taps(double sigma);

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
  double sigma_;
  int radius_ = 0;
  cl::Buffer taps_;
  cl::Kernel halve_, blur_;
  std::vector<cl::Kernel> blur_frame_, halve_frame_;  ///< one a format
};

inline kernel::hf_rect to_kernel(const Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

}  // namespace holdfast
