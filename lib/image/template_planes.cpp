#include "image/template_planes.hpp"

namespace holdfast {

TemplatePlanes::TemplatePlanes(const Device::Impl& device, ImageFilter& filter, const Level& largest)
    : device_(device), filter_(filter) {
  if (device.strips) {
    planes_ = device.kernel("pixel_planes");
    render_planes_ = device.kernel("view_planes");
  } else {
    planes_ = device.kernel("template_planes");
    blurred_ = device.zeroed_buffer((largest.elements * HF_PIXEL + kGuardFloats) * sizeof(float));
  }
}

void TemplatePlanes::enqueue(const cl::Buffer& pixels, const cl::Buffer& depth, const Level& level, const Rect& rect,
                             const kernel::hf_template& limits, const Out& out) {
  if (device_.strips) {
    set_arguments(planes_, pixels, depth, level.layout, to_kernel(rect), filter_.taps(), filter_.radius(), limits,
                  out.value, out.dx, out.dy, out.usable);
    filter_.enqueue_blocks(planes_, rect);
  } else {
    filter_.enqueue_blur(pixels, level, rect, blurred_);
    set_arguments(planes_, blurred_, depth, level.layout, to_kernel(rect), limits, out.value, out.dx, out.dy,
                  out.usable);
    device_.enqueue_rows(planes_, rect.width, rect.height);
  }
}

void TemplatePlanes::enqueue_render(const cl::Buffer& packed, const kernel::hf_view& view, const cl::Buffer& depth,
                                    const Level& level, const Rect& rect, const kernel::hf_template& limits,
                                    const Out& out) {
  set_arguments(render_planes_, packed, view, depth, level.layout, to_kernel(rect), filter_.taps(), filter_.radius(),
                limits, out.value, out.dx, out.dy, out.usable);
  filter_.enqueue_blocks(render_planes_, rect);
}

}  // namespace holdfast
