#pragma once

#include <array>
#include <vector>

#include "base/levels.hpp"
#include "holdfast/image_view.hpp"
#include "image/image_filter.hpp"

namespace holdfast {

/// The frame on the device: uploaded, converted, undistorted, halved, filtered. Only the asked-for region of each level
/// is valid.
class DeviceImage {
 public:
  DeviceImage(const Device::Impl& device, const Camera& camera, const std::vector<Level>& levels, ImageFilter& filter);

  /// Region of level 0 that contains `wanted` and that every level can be made of.
  Rect region(const Rect& wanted) const;

  /// The frame's stride, bytes. Throws Error(image) for a frame that enqueue_upload() would not take.
  std::size_t check(const ImageView& frame) const;
  std::size_t check(const DeviceImageView& frame) const;

  /// Copies the rows that `region` needs (all rows when the lens distorts). The frame's memory must stay valid until
  /// wait_for_upload() or anything later in the queue has been waited for.
  void enqueue_upload(const ImageView& frame, const Rect& region);
  void enqueue_upload(const DeviceImageView& frame, const Rect& region);

  /// Until frames in host memory are not read any more.
  void wait_for_upload() noexcept;

  /// Blurs a level inside `rect_of_level` (of the uploaded region); converts the frame or halves down to the level
  /// where that is needed and was not yet done.
  void enqueue_blur(int level, const Rect& rect_of_level);

  /// Converts the uploaded region, or halves it down to the level, where that was not yet done.
  void enqueue_pixels(int level);

  /// Not blurred, of enqueue_pixels(). Interleaved: three channels, coverage.
  const cl::Buffer& pixels(int level) const { return levels_buffers_[static_cast<std::size_t>(level)].pixels; }
  /// Pixels of the level that the uploaded region is.
  Rect uploaded(int level) const { return coarser(region_, level); }
  /// Interleaved: three channels, coverage.
  const cl::Buffer& blurred(int level) const { return levels_buffers_[static_cast<std::size_t>(level)].blurred; }
  /// Level pixels [x, x + width) x [y, y + height) whose central differences are exact.
  const Rect& valid(int level) const { return levels_buffers_[static_cast<std::size_t>(level)].valid; }
  const Camera& camera() const { return camera_; }
  /// One channel only.
  bool grey() const { return format_ == PixelFormat::grey8; }

 private:
  struct LevelBuffers {
    cl::Buffer pixels, blurred;
    Rect made;  ///< blurred of this frame
    Rect valid;
  };

  void set_frame(const cl::Buffer& buffer, PixelFormat format, std::size_t offset, std::size_t stride,
                 const Rect& region);
  void enqueue_convert();
  /// Whether the frame is blurred and halved without being converted.
  bool read_as_it_comes() const;

  const Device::Impl& device_;
  Camera camera_;
  const std::vector<Level>& levels_;
  ImageFilter& filter_;
  std::vector<LevelBuffers> levels_buffers_;
  cl::Buffer staging_;
  cl::Event uploaded_;
  std::array<cl::Kernel, 7> convert_;
  Rect region_;
  cl::Buffer bytes_;  ///< of the frame, as it came
  kernel::hf_frame frame_{};
  PixelFormat format_ = PixelFormat::bgr8;
  bool converted_ = false;         ///< the uploaded region
  std::size_t coarsest_made_ = 0;  ///< of it
};

}  // namespace holdfast
