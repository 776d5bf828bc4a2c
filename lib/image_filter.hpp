#pragma once

#include <vector>

#include "device_impl.hpp"
#include "levels.hpp"

namespace holdfast {

/// Separable Gaussian, halving and central differences; the same for the rendered view and the frame, which share its
/// scratch memory: what enqueue_blur() made must be used before the next is enqueued (one in-order queue).
class ImageFilter {
 public:
  /// `sigma` in pixels; 0 leaves images as they are. Throws Error(invalid_argument) when its reach exceeds
  /// HF_MAX_RADIUS.
  ImageFilter(const Device::Impl& device, double sigma, const std::vector<Level>& levels);

  /// Pixels beyond which the blur does not reach.
  int radius() const { return radius_; }

  /// Weights of a one-dimensional Gaussian: [0] the centre, then one side; they sum to one over both sides.
  static std::vector<float> gaussian_taps(double sigma);

  /// `rect` in pixels of the coarser level.
  void enqueue_halve(const cl::Buffer& in, const Level& in_level, const Rect& rect, const Level& out_level,
                     const cl::Buffer& out);
  /// Blurs interleaved premultiplied pixels and divides by coverage; returns where the result is.
  const cl::Buffer& enqueue_blur(const cl::Buffer& in, const Level& level, const Rect& rect);
  /// Value and derivatives, HF_FEATURE floats a pixel, of a blurred image.
  void enqueue_features(const cl::Buffer& in, const Level& level, const Rect& rect, const cl::Buffer& out);

 private:
  const Device::Impl& device_;
  int radius_;
  cl::Buffer taps_, scratch_, blurred_;
  cl::Kernel halve_, blur_rows_, blur_columns_, features_;
};

inline kernel::hf_rect to_kernel(const Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

}  // namespace holdfast
