// The Gaussian and halving against sums over whole windows.
#include <doctest/doctest.h>

#include "image_filter.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

void check_blur(const Device::Impl& device, Size size) {
  const Level level = level_of(size);
  const double sigma = 1.2;
  ImageFilter filter(device, sigma);
  const Planes in = random_pixels(size, 7);
  const cl::Buffer in_buffer = upload(device, to_memory(in, level));
  for (const int left : {0, 4}) {  // blocks of the whole image, and blocks that start and end elsewhere
    const Rect rect{left, left, level.padded_width - 2 * left, level.padded_height - 2 * left};
    const cl::Buffer blurred = zeroed(device, level, 4);
    filter.enqueue_blur(in_buffer, level, rect, blurred);
    const auto out = download<float>(device, blurred, level.elements * 4);
    Planes expected = reference::blurred(in, sigma);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const bool inside = x >= left && y >= left && x < rect.x + rect.width && y < rect.y + rect.height;
        for (int c = 0; c < 4 && !inside; ++c) expected.at(x, y, c) = 0;
      }
    }
    CHECK(largest_difference(out, level, expected) < 2e-5);
  }
}

void check_halve(const Device::Impl& device, Size size) {
  Camera camera{size.width, size.height, 100, 100, 0, 0, {}};
  const auto levels = make_levels(camera, 2);
  ImageFilter filter(device, 1.0);
  const Planes in = random_pixels(size, 9);
  const cl::Buffer in_buffer = upload(device, to_memory(in, levels[0])), out_buffer = zeroed(device, levels[1], 4);
  filter.enqueue_halve(in_buffer, levels[0], whole(levels[1]), levels[1], out_buffer);
  Planes expected(levels[1].width, levels[1].height, 4);
  for (int y = 0; y < expected.height; ++y) {
    for (int x = 0; x < expected.width; ++x) {
      for (int c = 0; c < 4; ++c) {
        expected.at(x, y, c) = (in.get(2 * x, 2 * y, c) + in.get(2 * x + 1, 2 * y, c) + in.get(2 * x, 2 * y + 1, c) +
                                in.get(2 * x + 1, 2 * y + 1, c)) /
                               4;
      }
    }
  }
  CHECK(largest_difference(download<float>(device, out_buffer, levels[1].elements * 4), levels[1], expected) < 1e-6);
}

}  // namespace

SMALL_AND_LARGE("blur", check_blur)
SMALL_AND_LARGE("halving", check_halve)
