// Frames of every format, plain and through a lens, against the definitions of the formats.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>

#include "holdfast/image_view.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

struct Frame {
  PixelFormat format;
  Size size;
  std::size_t stride;
  std::vector<std::uint8_t> bytes;
};

Frame random_frame(PixelFormat format, Size size) {
  Frame frame{format, size, packed_stride(format, size.width) + 5, {}};
  frame.bytes.resize(frame_bytes(format, size.height, frame.stride));
  std::mt19937 random(11);
  for (auto& byte : frame.bytes) byte = static_cast<std::uint8_t>(random());
  return frame;
}

std::array<double, 3> rgb_at(const Frame& frame, int x, int y) {
  const auto byte = [&](std::size_t row, int column) {
    return static_cast<double>(frame.bytes[row * frame.stride + static_cast<std::size_t>(column)]);
  };
  const auto row = static_cast<std::size_t>(y);
  const auto from_yuv = [](double luma, double u, double v) {
    // BT.601, limited range, from its definition: Kr = 0.299, Kb = 0.114.
    const double kr = 0.299, kb = 0.114, kg = 1 - kr - kb;
    const double l = (luma - 16) / 219, pb = (u - 128) / 224, pr = (v - 128) / 224;
    const double r = l + 2 * (1 - kr) * pr, b = l + 2 * (1 - kb) * pb, g = (l - kr * r - kb * b) / kg;
    return std::array<double, 3>{std::clamp(r, 0.0, 1.0), std::clamp(g, 0.0, 1.0), std::clamp(b, 0.0, 1.0)};
  };
  switch (frame.format) {
    case PixelFormat::bgr8:
      return {byte(row, 3 * x + 2) / 255, byte(row, 3 * x + 1) / 255, byte(row, 3 * x) / 255};
    case PixelFormat::rgb8:
      return {byte(row, 3 * x) / 255, byte(row, 3 * x + 1) / 255, byte(row, 3 * x + 2) / 255};
    case PixelFormat::rgba8:
      return {byte(row, 4 * x) / 255, byte(row, 4 * x + 1) / 255, byte(row, 4 * x + 2) / 255};
    case PixelFormat::bgra8:
      return {byte(row, 4 * x + 2) / 255, byte(row, 4 * x + 1) / 255, byte(row, 4 * x) / 255};
    case PixelFormat::grey8:
      return {byte(row, x) / 255, 0, 0};
    case PixelFormat::nv12: {
      const auto chroma = static_cast<std::size_t>(frame.size.height + y / 2);
      return from_yuv(byte(row, x), byte(chroma, x / 2 * 2), byte(chroma, x / 2 * 2 + 1));
    }
    case PixelFormat::yuyv:
      return from_yuv(byte(row, 2 * x), byte(row, x / 2 * 4 + 1), byte(row, x / 2 * 4 + 3));
  }
  return {};
}

/// The frame between its pixels, bilinear; nothing outside them.
std::array<double, 4> rgba_between(const Frame& frame, const Eigen::Vector2d& p) {
  const int x0 = static_cast<int>(p.x()), y0 = static_cast<int>(p.y());
  const double u = p.x() - x0, v = p.y() - y0;
  std::array<double, 4> out{0, 0, 0, 1};
  for (int j = 0; j <= 1; ++j) {
    for (int i = 0; i <= 1; ++i) {
      const auto rgb = rgb_at(frame, std::min(x0 + i, frame.size.width - 1), std::min(y0 + j, frame.size.height - 1));
      for (std::size_t c = 0; c < 3; ++c) out[c] += (i ? u : 1 - u) * (j ? v : 1 - v) * rgb[c];
    }
  }
  return out;
}

/// Pixels of level 0 as the device converts the frame, through a lens where `distorted` is 1, a fisheye where it is 2.
std::vector<float> converted(const Device::Impl& device, const char* kernel_name, const Frame& frame,
                             const Level& level, const Camera& camera, int distorted) {
  const std::size_t offset = 3;
  std::vector<std::uint8_t> shifted(offset + frame.bytes.size(), 0);
  std::copy(frame.bytes.begin(), frame.bytes.end(), shifted.begin() + offset);
  kernel::hf_frame f{};
  f.width = frame.size.width;
  f.height = frame.size.height;
  f.offset = static_cast<int>(offset);
  f.stride = static_cast<int>(frame.stride);
  f.distorted = distorted;
  f.fx = static_cast<float>(camera.fx);
  f.fy = static_cast<float>(camera.fy);
  f.cx = static_cast<float>(camera.cx);
  f.cy = static_cast<float>(camera.cy);
  float* k[] = {&f.k1, &f.k2, &f.p1, &f.p2, &f.k3, &f.k4, &f.k5, &f.k6};
  for (std::size_t i = 0; i < 8; ++i) *k[i] = static_cast<float>(camera.distortion[i]);
  cl::Kernel kernel = device.kernel(kernel_name);
  const cl::Buffer in = upload(device, shifted), out = zeroed(device, level, 4);
  set_arguments(kernel, in, f, to_kernel(whole(level)), level.layout, out);
  device.enqueue_rows(kernel, level.padded_width, level.padded_height);
  return download<float>(device, out, level.elements * 4);
}

void check_conversion(const Device::Impl& device, Size size) {
  const std::array<const char*, 7> names{"convert_bgr8", "convert_rgb8", "convert_rgba8", "convert_grey8",
                                         "convert_nv12", "convert_yuyv", "convert_bgra8"};
  const Level level = level_of(size);
  Camera camera = level.camera;
  camera.distortion = {-0.2, 0.05, 0.002, -0.001, 0.01, 0.01, -0.02, 0.003};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto format = static_cast<PixelFormat>(k);
    const bool paired = format == PixelFormat::nv12 || format == PixelFormat::yuyv;
    if (paired && (size.width % 2 || size.height % 2)) continue;  // these formats have no odd sizes
    CAPTURE(names[k]);
    const Frame frame = random_frame(format, size);
    for (const int distorted : {0, 1, 2}) {
      camera.lens = distorted == 2 ? LensModel::fisheye : LensModel::polynomial;
      const auto got = converted(device, names[k], frame, level, camera, distorted);
      double largest = 0;
      int at_border = 0;
      for (int y = 0; y < level.padded_height; ++y) {
        for (int x = 0; x < level.padded_width; ++x) {
          std::array<double, 4> expected{};
          double tolerance = 2e-6;
          if (x < size.width && y < size.height && distorted == 0) {
            expected = rgba_between(frame, {x, y});
          } else if (x < size.width && y < size.height) {
            // Camera::distort is checked against its own formula in test_pose_camera.
            const Eigen::Vector2d p = camera.distort({static_cast<double>(x), static_cast<double>(y)});
            const double margin = std::min({p.x(), p.y(), size.width - 1 - p.x(), size.height - 1 - p.y()});
            if (std::abs(margin) < 1e-3) {
              ++at_border;
              continue;
            }
            if (margin > 0) {
              expected = rgba_between(frame, p);
              tolerance = 1e-3;  // float positions of up to 640, 2^-14 pixel apart, on white noise
            }
          }
          const std::size_t e = element(level, x, y);
          for (std::size_t c = 0; c < 4; ++c) {
            largest = std::max(largest, std::abs(static_cast<double>(got[e * 4 + c]) - expected[c]) / tolerance);
          }
        }
      }
      CHECK(largest < 1);
      CHECK(at_border <= 2 * (size.width + size.height));
    }
  }
}

}  // namespace

SMALL_AND_LARGE("conversion of every frame format, plain and distorted", check_conversion)
