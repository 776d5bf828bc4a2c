// The Gaussian and halving against sums over whole windows.
#include <doctest/doctest.h>

#include <array>
#include <random>
#include <utility>
#include <vector>

#include "image/image_filter.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

void check_blur(const Device::Impl& device, Size size) {
  const Level level = level_of(size);
  ImageFilter filter(device);
  const Planes in = random_pixels(size, 7);
  const cl::Buffer in_buffer = upload(device, to_memory(in, level));
  for (const int left : {0, 4}) {  // blocks of the whole image, and blocks that start and end elsewhere
    const Rect rect{left, left, level.padded_width - 2 * left, level.padded_height - 2 * left};
    const cl::Buffer blurred = zeroed(device, level, 4);
    filter.enqueue_blur(in_buffer, level, rect, blurred);
    const auto out = download<float>(device, blurred, level.elements * 4);
    Planes expected = reference::blurred(in, ImageFilter::kSigma);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const bool inside = x >= left && y >= left && x < rect.x + rect.width && y < rect.y + rect.height;
        for (int c = 0; c < 4 && !inside; ++c) expected.at(x, y, c) = 0;
      }
    }
    CHECK(largest_difference(out, level, expected) < 2e-5);
  }
}

/// Where coverage is known to be 1 everywhere it is not looked at.
void check_blur_covered(const Device::Impl& device, Size size) {
  const Level level = level_of(size);
  ImageFilter filter(device);
  Planes in = random_pixels(size, 8);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) in.at(x, y, 3) = 1;
  }
  const cl::Buffer in_buffer = upload(device, to_memory(in, level)), blurred = zeroed(device, level, 4);
  filter.enqueue_blur(in_buffer, level, whole(level), blurred, {0, 0, size.width, size.height});
  const auto out = download<float>(device, blurred, level.elements * 4);
  CHECK(largest_difference(out, level, reference::blurred(in, ImageFilter::kSigma)) < 2e-6);
}

/// A frame of random bytes as a camera delivers it, and its pixels, all of which are covered.
struct Recorded {
  PixelFormat format;
  kernel::hf_frame frame{};
  std::vector<std::uint8_t> bytes;
  Planes pixels;
};

/// One of each format that can be filtered as it comes; none on devices that convert all frames.
std::vector<Recorded> recorded_frames(const Device::Impl& device, Size size) {
  struct Layout {
    PixelFormat format;
    int bytes;
    std::array<int, 3> at;  // of red, green and blue in a pixel; -1: none
  };
  const std::array<Layout, 4> layouts{{{PixelFormat::bgr8, 3, {2, 1, 0}},
                                       {PixelFormat::rgb8, 3, {0, 1, 2}},
                                       {PixelFormat::rgba8, 4, {0, 1, 2}},
                                       {PixelFormat::grey8, 1, {0, -1, -1}}}};
  std::vector<Recorded> all;
  for (const Layout& layout : layouts) {
    if (!ImageFilter(device).reads_frames(layout.format)) {
      CHECK(!device.strips);
      continue;
    }
    Recorded recorded{layout.format, {}, {}, Planes(size.width, size.height, 4)};
    kernel::hf_frame& frame = recorded.frame;
    frame.width = size.width;
    frame.height = size.height;
    frame.offset = 3;
    frame.stride = layout.bytes * size.width + 5;
    recorded.bytes.resize(static_cast<std::size_t>(frame.offset + frame.stride * size.height));
    std::mt19937 random(12);
    for (auto& byte : recorded.bytes) byte = static_cast<std::uint8_t>(random());
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const int pixel = frame.offset + y * frame.stride + layout.bytes * x;
        for (int c = 0; c < 3; ++c) {
          const int at = layout.at[static_cast<std::size_t>(c)];
          if (at >= 0) recorded.pixels.at(x, y, c) = recorded.bytes[static_cast<std::size_t>(pixel + at)] / 255.0;
        }
        recorded.pixels.at(x, y, 3) = 1;
      }
    }
    all.push_back(std::move(recorded));
  }
  return all;
}

/// Frames as they come, blurred without being converted.
void check_blur_frame(const Device::Impl& device, Size size) {
  const Level level = level_of(size);
  ImageFilter filter(device);
  for (const Recorded& recorded : recorded_frames(device, size)) {
    CAPTURE(static_cast<int>(recorded.format));
    const cl::Buffer in = upload(device, recorded.bytes), blurred = zeroed(device, level, 4);
    filter.enqueue_blur(in, recorded.format, recorded.frame, level, whole(level), blurred);
    const auto out = download<float>(device, blurred, level.elements * 4);
    CHECK(largest_difference(out, level, reference::blurred(recorded.pixels, ImageFilter::kSigma)) < 2e-6);
  }
}

/// Means of 2x2 pixels.
Planes halved(const Planes& in, const Level& level) {
  Planes out(level.width, level.height, 4);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      for (int c = 0; c < 4; ++c) {
        out.at(x, y, c) = (in.get(2 * x, 2 * y, c) + in.get(2 * x + 1, 2 * y, c) + in.get(2 * x, 2 * y + 1, c) +
                           in.get(2 * x + 1, 2 * y + 1, c)) /
                          4;
      }
    }
  }
  return out;
}

/// Frames as they come, halved without being converted.
void check_halve_frame(const Device::Impl& device, Size size) {
  const auto levels = make_levels(Camera{size.width, size.height, 100, 100, 0, 0, {}}, 2);
  ImageFilter filter(device);
  for (const Recorded& recorded : recorded_frames(device, size)) {
    CAPTURE(static_cast<int>(recorded.format));
    const cl::Buffer in = upload(device, recorded.bytes), out = zeroed(device, levels[1], 4);
    filter.enqueue_halve(in, recorded.format, recorded.frame, whole(levels[1]), levels[1], out);
    const auto got = download<float>(device, out, levels[1].elements * 4);
    CHECK(largest_difference(got, levels[1], halved(recorded.pixels, levels[1])) < 1e-6);
  }
}

void check_halve(const Device::Impl& device, Size size) {
  Camera camera{size.width, size.height, 100, 100, 0, 0, {}};
  const auto levels = make_levels(camera, 2);
  ImageFilter filter(device);
  const Planes in = random_pixels(size, 9);
  const cl::Buffer in_buffer = upload(device, to_memory(in, levels[0])), out_buffer = zeroed(device, levels[1], 4);
  filter.enqueue_halve(in_buffer, levels[0], whole(levels[1]), levels[1], out_buffer);
  const Planes expected = halved(in, levels[1]);
  CHECK(largest_difference(download<float>(device, out_buffer, levels[1].elements * 4), levels[1], expected) < 1e-6);
}

}  // namespace

SMALL_AND_LARGE("blur", check_blur)
SMALL_AND_LARGE("blur of what is covered everywhere", check_blur_covered)
SMALL_AND_LARGE("blur of frames as they come", check_blur_frame)
SMALL_AND_LARGE("halving", check_halve)
SMALL_AND_LARGE("halving of frames as they come", check_halve_frame)
