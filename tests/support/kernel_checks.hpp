#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "image/image_filter.hpp"
#include "support/reference.hpp"

/// What the suites of the kernels share: a check is run on small odd sizes and a large one, on both partitions, and
/// compares a level's memory with reference::Planes.
namespace holdfast::test {

struct Size {
  int width, height;
};

/// Focal lengths that differ, the principal point off the centre.
Level level_of(Size size);

inline Rect whole(const Level& level) { return {0, 0, level.padded_width, level.padded_height}; }

/// Where a pixel stands in a plane of the level's memory.
inline std::size_t element(const Level& level, int x, int y) {
  return static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
}

/// Random interleaved pixels, premultiplied by a coverage that is often 0 or 1.
reference::Planes random_pixels(Size size, unsigned seed);

/// As the kernels hold it.
inline double as_float(double value) { return static_cast<double>(static_cast<float>(value)); }

/// A frame of two colours with a straight edge through `middle`, sampled 64 times a pixel: `beyond` is where the normal
/// points.
reference::Planes two_colors(Size size, const Eigen::Vector2d& normal, const Eigen::Vector2d& middle,
                             const Eigen::Vector3d& before, const Eigen::Vector3d& beyond);

/// Memory of a level with all channels of a pixel side by side, zero outside the image.
std::vector<float> to_memory(const reference::Planes& planes, const Level& level);

/// The same, a plane a channel.
std::vector<float> to_plane_memory(const reference::Planes& planes, const Level& level);

/// Between interleaved memory, as downloaded, and what it should be.
double largest_difference(const std::vector<float>& memory, const Level& level, const reference::Planes& expected);

template <typename T>
cl::Buffer upload(const Device::Impl& device, std::vector<T> values) {
  return cl::Buffer(device.context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(T), values.data());
}

template <typename T>
std::vector<T> download(const Device::Impl& device, const cl::Buffer& buffer, std::size_t count) {
  std::vector<T> values(count);
  device.queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(T), values.data());
  return values;
}

/// Zeros: `channels` values of type T for every pixel of a level.
template <typename T = float>
cl::Buffer zeroed(const Device::Impl& device, const Level& level, std::size_t channels = 1) {
  return device.zeroed_buffer((level.elements + kGuardFloats) * channels * sizeof(T));
}

using KernelCheck = void (*)(const Device::Impl& device, Size size);

/// On each partition; on HOLDFAST_TEST_PARTITION's alone where that is set: rusticl takes many minutes to compile
/// strips.
void check_small(KernelCheck check);
void check_large(KernelCheck check);

}  // namespace holdfast::test

/// Two test cases. Oclgrind runs only the small sizes, and knows the large one by its name (SecondOpenCL.cmake).
#define SMALL_AND_LARGE(NAME, CHECK_FUNCTION)                                        \
  TEST_CASE(NAME ": 1x1 and 17x13") { holdfast::test::check_small(CHECK_FUNCTION); } \
  TEST_CASE(NAME ": 640x480") { holdfast::test::check_large(CHECK_FUNCTION); }
