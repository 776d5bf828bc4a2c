#pragma once

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "image/image_filter.hpp"

namespace holdfast {

/// The view's pixels -> what the frame is compared with: blurred values, their differences, usability.
class TemplatePlanes {
 public:
  /// A plane has Level::elements values; three planes of values and differences, one a channel.
  struct Out {
    const cl::Buffer &value, &dx, &dy, &usable;
  };

  /// `largest`: no level is larger.
  TemplatePlanes(const Device::Impl& device, ImageFilter& filter, const Level& largest);

  /// From interleaved pixels, premultiplied by coverage, or, where `render` has a stride (strips only), from a packed
  /// render of `rect` whose alpha says what is known. `rect` in whole tiles.
  void enqueue(const cl::Buffer& pixels, const kernel::hf_view& render, const cl::Buffer& depth, const Level& level,
               const Rect& rect, const kernel::hf_template& limits, const Out& out);

 private:
  const Device::Impl& device_;
  ImageFilter& filter_;
  cl::Buffer blurred_;  ///< of the level last enqueued; groups only
  cl::Kernel planes_;
};

}  // namespace holdfast
