#pragma once

#include <cstddef>

#include "base/levels.hpp"
#include "device/device_impl.hpp"

namespace holdfast {

/// Copies `rect` of a level from a buffer, `bytes` a pixel, to packed rows in host memory. `plane`: elements of the
/// level before the plane that is read. Waits for the device.
void read_rect(const Device::Impl& device, const cl::Buffer& buffer, const Level& level, const Rect& rect,
               std::size_t bytes, void* out, std::size_t plane = 0);

/// The other way round.
void write_rect(const Device::Impl& device, const cl::Buffer& buffer, const Level& level, const Rect& rect,
                std::size_t bytes, const void* in);

}  // namespace holdfast
