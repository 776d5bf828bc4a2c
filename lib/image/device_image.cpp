#include "image/device_image.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace holdfast {
namespace {

constexpr std::size_t kMostBytes = std::numeric_limits<int>::max();  // kernels count in int

/// Throws where a frame, in host or in device memory, cannot be read as its fields say. Returns the stride, in bytes.
template <typename View>
std::size_t check_frame(const View& frame, const Camera& camera) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::image, message); };
  const auto pixels = [](int width, int height) { return std::to_string(width) + "x" + std::to_string(height); };
  const std::string size = pixels(frame.width, frame.height);
  if (frame.width <= 0 || frame.height <= 0) {
    refuse("the frame is empty (" + size + "): was it read? is the recording at its end?");
  }
  if (frame.width != camera.width || frame.height != camera.height) {
    refuse("the frame is " + size + " pixels but the camera was calibrated for " + pixels(camera.width, camera.height) +
           "; use the matching calibration, or rescale it (Camera::rescaled)");
  }
  const int format = static_cast<int>(frame.format);
  if (format < 0 || format > static_cast<int>(PixelFormat::bgra8)) {
    refuse("the frame's format, " + std::to_string(format) + ", is none of PixelFormat's");
  }
  const bool nv12 = frame.format == PixelFormat::nv12;
  if ((nv12 && frame.height % 2 != 0) || ((nv12 || frame.format == PixelFormat::yuyv) && frame.width % 2 != 0)) {
    refuse("NV12 and YUYV frames have an even width (and NV12 an even height), this one is " + size +
           "; convert it to RGB8");
  }
  const std::size_t stride = frame.stride_bytes, packed = packed_stride(frame.format, frame.width);
  if (stride == 0) return packed;
  if (stride < packed) {
    refuse("the frame's stride of " + std::to_string(stride) + " bytes is shorter than a row (" +
           std::to_string(packed) + " bytes)");
  }
  if (stride > kMostBytes) {
    refuse("the frame's stride of " + std::to_string(stride) + " bytes is longer than any row: is it negative?");
  }
  return stride;
}

}  // namespace

DeviceImage::DeviceImage(const Device::Impl& device, const Camera& camera, const std::vector<Level>& levels,
                         ImageFilter& filter)
    : device_(device), camera_(camera), levels_(levels), filter_(filter) {
  for (const Level& level : levels) {
    LevelBuffers buffers;
    buffers.pixels = device.zeroed_buffer((level.elements * HF_PIXEL + kGuardFloats) * sizeof(float));
    buffers.blurred = device.zeroed_buffer((level.elements * HF_PIXEL + kGuardFloats) * sizeof(float));
    levels_buffers_.push_back(std::move(buffers));
  }
  staging_ = device.zeroed_buffer(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 4 +
                                  kGuardFloats);
  const std::array<const char*, 7> names{"convert_bgr8", "convert_rgb8", "convert_rgba8", "convert_grey8",
                                         "convert_nv12", "convert_yuyv", "convert_bgra8"};
  for (std::size_t i = 0; i < names.size(); ++i) convert_[i] = device.kernel(names[i]);
}

Rect DeviceImage::region(const Rect& wanted) const {
  // Rows of the coarsest level must start at whole vectors of pixels.
  const int alignment = 4 << (levels_.size() - 1);
  return aligned(wanted, alignment, levels_[0].padded_width, levels_[0].padded_height);
}

std::size_t DeviceImage::check(const ImageView& frame) const {
  const std::size_t stride = check_frame(frame, camera_);
  if (frame.data == nullptr) throw Error(ErrorCode::image, "the frame has no data");
  return stride;
}

std::size_t DeviceImage::check(const DeviceImageView& frame) const {
  const std::size_t stride = check_frame(frame, camera_);
  if (frame.buffer == nullptr) throw Error(ErrorCode::image, "the frame has no OpenCL buffer");
  const cl::Buffer buffer(frame.buffer, true);
  if (buffer.getInfo<CL_MEM_CONTEXT>()() != device_.context()) {
    throw Error(ErrorCode::image, "the frame's OpenCL buffer belongs to another context than the tracker's device");
  }
  if (frame.offset_bytes > kMostBytes) {
    throw Error(ErrorCode::image,
                "the frame begins more than 2 GiB into its OpenCL buffer; give it a buffer of its own");
  }
  const std::size_t end = frame.offset_bytes + frame_bytes(frame.format, frame.height, stride);
  if (buffer.getInfo<CL_MEM_SIZE>() < end) {
    throw Error(ErrorCode::image, "the frame's OpenCL buffer is smaller than its size, stride and offset say");
  }
  if (end > kMostBytes) {
    throw Error(ErrorCode::image, "the frame ends more than 2 GiB into its OpenCL buffer; give it a buffer of its own");
  }
  return stride;
}

void DeviceImage::wait_for_upload() noexcept {
  if (uploaded_() == nullptr) return;
  // Not the wrapper's wait, which throws; a queue that failed reads nothing any more.
  clWaitForEvents(1, &uploaded_());
  uploaded_ = {};
}

void DeviceImage::enqueue_upload(const ImageView& frame, const Rect& region) {
  const std::size_t stride = check(frame);
  const std::size_t packed = packed_stride(frame.format, frame.width);
  const bool all = camera_.has_distortion();
  const std::size_t first = all ? 0 : static_cast<std::size_t>(std::min(region.y, frame.height));
  const std::size_t last = all ? static_cast<std::size_t>(frame.height)
                               : static_cast<std::size_t>(std::min(region.y + region.height, frame.height));
  const auto copy_rows = [&](std::size_t from, std::size_t to) {
    if (to <= from) return;
    if (stride == packed) {
      device_.queue.enqueueWriteBuffer(staging_, CL_FALSE, from * packed, (to - from) * packed,
                                       frame.data + from * stride, nullptr, &uploaded_);
    } else {
      const cl::array<std::size_t, 3> origin{0, from, 0}, extent{packed, to - from, 1};
      device_.queue.enqueueWriteBufferRect(staging_, CL_FALSE, origin, origin, extent, packed, 0, stride, 0, frame.data,
                                           nullptr, &uploaded_);
    }
  };
  copy_rows(first, last);
  if (frame.format == PixelFormat::nv12) {
    const std::size_t height = static_cast<std::size_t>(frame.height);
    copy_rows(height + first / 2, height + (last + 1) / 2);
  }
  set_frame(staging_, frame.format, 0, packed, region);
}

void DeviceImage::enqueue_upload(const DeviceImageView& frame, const Rect& region) {
  const std::size_t stride = check(frame);
  set_frame(cl::Buffer(frame.buffer, true), frame.format, frame.offset_bytes, stride, region);
}

void DeviceImage::set_frame(const cl::Buffer& buffer, PixelFormat format, std::size_t offset, std::size_t stride,
                            const Rect& region) {
  region_ = region;
  bytes_ = buffer;
  format_ = format;
  frame_ = {};
  frame_.width = camera_.width;
  frame_.height = camera_.height;
  frame_.offset = static_cast<int>(offset);
  frame_.stride = static_cast<int>(stride);
  frame_.distorted = camera_.lens == LensModel::fisheye ? 2 : camera_.has_distortion() ? 1 : 0;
  set_intrinsics(frame_, camera_);
  float* coefficients[] = {&frame_.k1, &frame_.k2, &frame_.p1, &frame_.p2,
                           &frame_.k3, &frame_.k4, &frame_.k5, &frame_.k6};
  for (std::size_t i = 0; i < 8; ++i) *coefficients[i] = static_cast<float>(camera_.distortion[i]);
  converted_ = false;
  coarsest_made_ = 0;
  for (LevelBuffers& buffers : levels_buffers_) buffers.made = {};
}

void DeviceImage::enqueue_convert() {
  if (std::exchange(converted_, true)) return;
  cl::Kernel& convert = convert_[static_cast<std::size_t>(format_)];
  set_arguments(convert, bytes_, frame_, to_kernel(region_), levels_[0].layout, levels_buffers_[0].pixels);
  device_.enqueue_rows(convert, region_.width, region_.height);
}

bool DeviceImage::read_as_it_comes() const { return frame_.distorted == 0 && filter_.reads_frames(format_); }

void DeviceImage::enqueue_pixels(int level) {
  if (level == 0) enqueue_convert();
  for (; coarsest_made_ < static_cast<std::size_t>(level); ++coarsest_made_) {
    const std::size_t l = coarsest_made_ + 1;
    const Rect rect = coarser(region_, static_cast<int>(l));
    const cl::Buffer& out = levels_buffers_[l].pixels;
    if (l == 1 && read_as_it_comes()) {
      filter_.enqueue_halve(bytes_, format_, frame_, rect, levels_[l], out);
    } else {
      if (l == 1) enqueue_convert();
      filter_.enqueue_halve(levels_buffers_[l - 1].pixels, levels_[l - 1], rect, levels_[l], out);
    }
  }
}

void DeviceImage::enqueue_blur(int level_index, const Rect& rect_of_level) {
  const auto l = static_cast<std::size_t>(level_index);
  const Level& level = levels_[l];
  const Rect available = coarser(region_, level_index);
  Rect rect = aligned(rect_of_level, 4, level.padded_width, level.padded_height);
  const int x0 = std::max(rect.x, available.x), y0 = std::max(rect.y, available.y);
  const int x1 = std::min(rect.x + rect.width, available.x + available.width);
  const int y1 = std::min(rect.y + rect.height, available.y + available.height);
  rect = {x0, y0, std::max(0, x1 - x0), std::max(0, y1 - y0)};
  LevelBuffers& buffers = levels_buffers_[l];
  if (contains(buffers.made, rect)) return;
  buffers.made = rect;
  if (rect.empty()) {
    buffers.valid = {};
    return;
  }
  if (l == 0 && read_as_it_comes()) {
    filter_.enqueue_blur(bytes_, format_, frame_, level, rect, buffers.blurred);
  } else {
    enqueue_pixels(level_index);
    const Rect covered = frame_.distorted != 0 ? Rect{} : Rect{0, 0, camera_.width >> l, camera_.height >> l};
    filter_.enqueue_blur(buffers.pixels, level, rect, buffers.blurred, covered);
  }

  // Inside the frame the blur and the differences at the region's rim have used pixels that were not made; at the
  // frame's own border the blur is normalised by coverage and only the outermost difference is not.
  const int rim = HF_BLUR_RADIUS + 1;
  const int left = x0 > 0 ? x0 + rim : 1, top = y0 > 0 ? y0 + rim : 1;
  const int right = x1 < level.width ? x1 - rim : level.width - 1;
  const int bottom = y1 < level.height ? y1 - rim : level.height - 1;
  buffers.valid = {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

}  // namespace holdfast
