#pragma once

#include <cstddef>
#include <cstdint>

#include "holdfast/export.hpp"

/// OpenCL's memory handle, declared so that no OpenCL header is needed here.
struct _cl_mem;

namespace holdfast {

/// Byte layouts of frames as cameras and decoders deliver them.
enum class PixelFormat {
  bgr8,   ///< 3 bytes a pixel
  rgb8,   ///< 3 bytes a pixel
  rgba8,  ///< 4 bytes a pixel, alpha ignored
  grey8,  ///< 1 byte a pixel
  /// A full plane of Y, then, `height` strides on and with the same stride, a half-size plane of interleaved U, V
  /// (BT.601, limited range; each pair the mean of its 2x2 pixels. Pairs taken at the left two of them, as most video
  /// has them, shift colour by half a pixel and the pose with it, by more than its covariance says).
  nv12,
  yuyv,   ///< 2 bytes a pixel: Y0 U Y1 V (BT.601, limited range)
  bgra8,  ///< 4 bytes a pixel, alpha ignored
};

/// A frame in host memory; not owned, read only during the call it is passed to.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0;                 ///< pixels
  int height = 0;                ///< pixels
  std::size_t stride_bytes = 0;  ///< bytes from a row to the next; 0: rows are packed
  PixelFormat format = PixelFormat::bgr8;
};

/// A frame that already is an OpenCL buffer (cl_mem) of the tracker's context; not owned. Work that fills it must be
/// enqueued on the tracker's queue before, or have finished.
struct DeviceImageView {
  _cl_mem* buffer = nullptr;
  std::size_t offset_bytes = 0;
  int width = 0;
  int height = 0;
  std::size_t stride_bytes = 0;  ///< 0: rows are packed
  PixelFormat format = PixelFormat::bgr8;
};

/// A rectangle of whole pixels: columns [x, x + width), rows [y, y + height).
struct Rect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
};

/// Bytes of one packed row of the format's first plane.
HOLDFAST_EXPORT std::size_t packed_stride(PixelFormat format, int width);

/// Bytes that a frame occupies in all its planes.
HOLDFAST_EXPORT std::size_t frame_bytes(PixelFormat format, int height, std::size_t stride_bytes);

}  // namespace holdfast
