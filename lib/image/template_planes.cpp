#include "image/template_planes.hpp"

namespace holdfast {

TemplatePlanes::TemplatePlanes(const Device::Impl& device, ImageFilter& filter, const Level& largest)
    : device_(device), filter_(filter), planes_(device.kernel("template_planes")) {
  if (!device.strips) blurred_ = device.zeroed_buffer((largest.elements * HF_PIXEL + kGuardFloats) * sizeof(float));
}

void TemplatePlanes::enqueue(const cl::Buffer& pixels, const kernel::hf_view& render, const cl::Buffer& depth,
                             const Level& level, const Rect& rect, const kernel::hf_template& limits, const Out& out) {
  if (!device_.strips) filter_.enqueue_blur(pixels, level, rect, blurred_);
  set_arguments(planes_, device_.strips ? pixels : blurred_, render, depth, level.layout, to_kernel(rect), limits,
                out.value, out.dx, out.dy, out.usable);
  if (device_.strips) {
    filter_.enqueue_blocks(planes_, rect);
  } else {
    device_.enqueue_rows(planes_, rect.width, rect.height);
  }
}

}  // namespace holdfast
