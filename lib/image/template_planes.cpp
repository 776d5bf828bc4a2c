#include "image/template_planes.hpp"

namespace holdfast {
namespace {

/// From argument `index` on.
void set_arguments(cl::Kernel& kernel, cl_uint index, const kernel::hf_template& limits,
                   const TemplatePlanes::Out& out) {
  kernel.setArg(index, limits);
  kernel.setArg(index + 1, out.value);
  kernel.setArg(index + 2, out.dx);
  kernel.setArg(index + 3, out.dy);
  kernel.setArg(index + 4, out.usable);
}

}  // namespace

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
  if (!device_.strips) filter_.enqueue_blur(pixels, level, rect, blurred_);
  planes_.setArg(0, device_.strips ? pixels : blurred_);
  planes_.setArg(1, depth);
  if (device_.strips) {
    filter_.set_blur(planes_, 2, level, rect);
    set_arguments(planes_, 6, limits, out);
    filter_.enqueue_blocks(planes_, rect);
  } else {
    planes_.setArg(2, level.layout);
    planes_.setArg(3, to_kernel(rect));
    set_arguments(planes_, 4, limits, out);
    device_.enqueue_rows(planes_, rect.width, rect.height);
  }
}

void TemplatePlanes::enqueue_render(const cl::Buffer& packed, const kernel::hf_view& view, const cl::Buffer& depth,
                                    const Level& level, const Rect& rect, const kernel::hf_template& limits,
                                    const Out& out) {
  render_planes_.setArg(0, packed);
  render_planes_.setArg(1, view);
  render_planes_.setArg(2, depth);
  filter_.set_blur(render_planes_, 3, level, rect);
  set_arguments(render_planes_, 7, limits, out);
  filter_.enqueue_blocks(render_planes_, rect);
}

}  // namespace holdfast
