#include "image/image_filter.hpp"

namespace holdfast {

ImageFilter::ImageFilter(const Device::Impl& device) : device_(device) {
  halve_ = device.kernel("halve");
  blur_ = device.kernel("blur");
  if (!device.strips) return;
  static_assert(static_cast<int>(PixelFormat::bgr8) == HF_BGR8 && static_cast<int>(PixelFormat::rgb8) == HF_RGB8 &&
                static_cast<int>(PixelFormat::rgba8) == HF_RGBA8 && static_cast<int>(PixelFormat::grey8) == HF_GREY8);
  for (const char* name : {"blur_bgr8", "blur_rgb8", "blur_rgba8", "blur_grey8"}) {
    blur_frame_.push_back(device.kernel(name));
  }
  for (const char* name : {"halve_bgr8", "halve_rgb8", "halve_rgba8", "halve_grey8"}) {
    halve_frame_.push_back(device.kernel(name));
  }
}

void ImageFilter::enqueue_halve(const cl::Buffer& in, const Level& in_level, const Rect& rect, const Level& out_level,
                                const cl::Buffer& out) {
  set_arguments(halve_, in, in_level.layout, to_kernel(rect), out_level.layout, out);
  device_.enqueue_rows(halve_, rect.width, rect.height);
}

void ImageFilter::enqueue_halve(const cl::Buffer& in, PixelFormat format, const kernel::hf_frame& frame,
                                const Rect& rect, const Level& out_level, const cl::Buffer& out) {
  cl::Kernel& halve = halve_frame_[static_cast<std::size_t>(format)];
  set_arguments(halve, in, frame, to_kernel(rect), out_level.layout, out);
  device_.enqueue_rows(halve, rect.width, rect.height);
}

void ImageFilter::enqueue_blocks(const cl::Kernel& kernel, const Rect& rect) const {
  const int columns = device_.strips ? HF_BLUR_COLUMNS : HF_TILE, rows = device_.strips ? HF_BLUR_ROWS : HF_TILE;
  device_.enqueue_tiles(kernel, (rect.width + columns - 1) / columns, (rect.height + rows - 1) / rows);
}

void ImageFilter::enqueue_blur(const cl::Buffer& in, const Level& level, const Rect& rect, const cl::Buffer& out,
                               const Rect& covered) {
  set_arguments(blur_, in, level.layout, to_kernel(rect), out, to_kernel(covered));
  enqueue_blocks(blur_, rect);
}

void ImageFilter::enqueue_blur(const cl::Buffer& in, PixelFormat format, const kernel::hf_frame& frame,
                               const Level& level, const Rect& rect, const cl::Buffer& out) {
  cl::Kernel& blur = blur_frame_[static_cast<std::size_t>(format)];
  set_arguments(blur, in, frame, level.layout, to_kernel(rect), out);
  enqueue_blocks(blur, rect);
}

}  // namespace holdfast
