#include "holdfast/image_view.hpp"

namespace holdfast {

std::size_t packed_stride(PixelFormat format, int width) {
  const std::size_t columns = width > 0 ? static_cast<std::size_t>(width) : 0;
  switch (format) {
    case PixelFormat::bgr8:
    case PixelFormat::rgb8:
      return columns * 3;
    case PixelFormat::rgba8:
    case PixelFormat::bgra8:
      return columns * 4;
    case PixelFormat::yuyv:
      return (columns + 1) / 2 * 4;  // two pixels share a chroma sample: rows hold whole pairs
    case PixelFormat::grey8:
    case PixelFormat::nv12:
      break;
  }
  return columns;
}

std::size_t frame_bytes(PixelFormat format, int height, std::size_t stride_bytes) {
  const std::size_t rows = height > 0 ? static_cast<std::size_t>(height) : 0;
  const std::size_t chroma_rows = format == PixelFormat::nv12 ? (rows + 1) / 2 : 0;
  return stride_bytes * (rows + chroma_rows);
}

}  // namespace holdfast
