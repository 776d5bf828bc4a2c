#include "image/level_rect.hpp"

#include <array>

namespace holdfast {
namespace {

/// Where a rectangle begins in a buffer and how large it is, in bytes and rows, as OpenCL wants it.
struct Region {
  std::array<std::size_t, 3> origin, size;
  std::size_t pitch;

  Region(const Level& level, const Rect& rect, std::size_t bytes, std::size_t plane)
      : origin{(plane + static_cast<std::size_t>(level.layout.origin + rect.y * level.layout.stride + rect.x)) * bytes,
               0, 0},
        size{static_cast<std::size_t>(rect.width) * bytes, static_cast<std::size_t>(rect.height), 1},
        pitch(static_cast<std::size_t>(level.layout.stride) * bytes) {}
};

}  // namespace

void read_rect(const Device::Impl& device, const cl::Buffer& buffer, const Level& level, const Rect& rect,
               std::size_t bytes, void* out, std::size_t plane) {
  const Region region(level, rect, bytes, plane);
  device.queue.enqueueReadBufferRect(buffer, CL_TRUE, region.origin, {0, 0, 0}, region.size, region.pitch, 0,
                                     region.size[0], 0, out);
}

void write_rect(const Device::Impl& device, const cl::Buffer& buffer, const Level& level, const Rect& rect,
                std::size_t bytes, const void* in) {
  const Region region(level, rect, bytes, 0);
  device.queue.enqueueWriteBufferRect(buffer, CL_TRUE, region.origin, {0, 0, 0}, region.size, region.pitch, 0,
                                      region.size[0], 0, in);
}

}  // namespace holdfast
