// The rendered view's colour made as coarse as codecs keep it, beside its brightness: equation 6b of docs/math.md.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

constexpr double kNear = 0.5, kFar = 0.9;

/// Red, green and blue in bytes, and 0 or 1 for what is known of the surface; of the latter, `window` has the depth.
struct Render {
  Planes pixels;
  std::vector<float> window;
  std::vector<std::uint8_t> packed;
  int stride;

  Render(const Level& level, Size size) : pixels(size.width, size.height, 4), stride(level.padded_width + 3) {
    window.assign(static_cast<std::size_t>(stride * level.padded_height), 1.0f);
    packed.assign((window.size() + 2 * static_cast<std::size_t>(HF_RENDER_GUARD)) * 4, 0);
  }

  void set(int x, int y, const std::array<int, 3>& color, bool known) {
    const auto i = static_cast<std::size_t>(y * stride + x);
    std::uint8_t* p = packed.data() + 4 * (static_cast<std::size_t>(HF_RENDER_GUARD) + i);
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = static_cast<std::uint8_t>(color[c]);
      pixels.at(x, y, static_cast<int>(c)) = known ? color[c] : 0;
    }
    p[3] = known ? 255 : 0;
    pixels.at(x, y, 3) = known ? 1 : 0;
    window[i] = 0.25f;
  }
};

double luma(const std::array<double, 3>& color) { return 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2]; }

/// In [0, 1]; the whole window's sum at once.
Planes with_coarse_color(const Planes& in, double variance) {
  constexpr std::array<double, 5> weights{1, 4, 6, 4, 1};
  Planes out(in.width, in.height, 4);
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      if (in.get(x, y, 3) == 0) continue;
      std::array<double, 3> sharp{}, sum{};
      double total = 0;
      for (int j = 0; j < 5; ++j) {
        for (int i = 0; i < 5; ++i) {
          const double weight = weights[static_cast<std::size_t>(j)] * weights[static_cast<std::size_t>(i)];
          total += weight * in.get(x + i - 2, y + j - 2, 3);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * in.get(x + i - 2, y + j - 2, static_cast<int>(c));
        }
      }
      for (std::size_t c = 0; c < 3; ++c) {
        sharp[c] = in.get(x, y, static_cast<int>(c));
        sum[c] /= total;
      }
      const double brightness = luma(sharp), coarse_brightness = luma(sum);
      for (std::size_t c = 0; c < 3; ++c) {
        const double color = sharp[c] - brightness, coarse_color = sum[c] - coarse_brightness;
        out.at(x, y, static_cast<int>(c)) = (brightness + (1 - variance) * color + variance * coarse_color) / 255;
      }
      out.at(x, y, 3) = 1;
    }
  }
  return out;
}

struct Unpacked {
  std::vector<float> pixels, depth;
};

Unpacked unpacked(const Device::Impl& device, const Level& level, const Render& render, double variance) {
  const cl::Buffer packed = upload(device, render.packed), window = upload(device, render.window);
  const cl::Buffer pixels = zeroed(device, level, 4), depth = zeroed(device, level);
  kernel::hf_view view{};
  view.stride = render.stride;
  view.height = level.padded_height;
  view.color_variance = static_cast<float>(variance);
  view.near_plane = static_cast<float>(kNear);
  view.far_plane = static_cast<float>(kFar);
  cl::Kernel kernel = device.kernel("unpack_view_coarse_color");
  set_arguments(kernel, packed, window, view, to_kernel(whole(level)), level.layout, pixels, depth);
  device.enqueue_rows(kernel, level.padded_width, level.padded_height);
  return {download<float>(device, pixels, level.elements * 4), download<float>(device, depth, level.elements)};
}

void check_coarse_color(const Device::Impl& device, Size size) {
  const Level level = make_levels(Camera{size.width, size.height, 100, 100, 0, 0, {}}, 1)[0];
  std::mt19937 random(9);
  std::uniform_int_distribution<int> byte(0, 255);
  Render render(level, size);
  Planes depth(size.width, size.height, 1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      render.set(x, y, {byte(random), byte(random), byte(random)}, byte(random) < 200);
      depth.at(x, y, 0) = kNear * kFar / (kFar - 0.25 * (kFar - kNear));
    }
  }
  for (const double variance : {0.0, 0.25, 1.0}) {
    const Unpacked result = unpacked(device, level, render, variance);
    CHECK(largest_difference(result.pixels, level, with_coarse_color(render.pixels, variance)) < 1e-6);
    CHECK(largest_difference(result.depth, level, depth) < 1e-6);
    CHECK(unpacked(device, level, render, variance).pixels == result.pixels);
  }
}

/// What it is for, in words: a coloured dot among grey keeps its brightness and spreads its colour by the variance.
void check_dot(const Device::Impl& device, Size size) {
  if (size.width < 13 || size.height < 13) return;
  const Level level = make_levels(Camera{size.width, size.height, 100, 100, 0, 0, {}}, 1)[0];
  Render render(level, size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) render.set(x, y, {100, 100, 100}, true);
  }
  const int dot_x = size.width / 2, dot_y = size.height / 2;
  render.set(dot_x, dot_y, {220, 60, 90}, true);
  for (const double variance : {0.5, 1.0}) {
    const std::vector<float> pixels = unpacked(device, level, render, variance).pixels;
    std::array<double, 3> along{}, across{};  // sum, first and second moment of how red it is
    double brightness_off = 0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const float* p = pixels.data() + 4 * element(level, x, y);
        const std::array<double, 3> color{static_cast<double>(p[0]), static_cast<double>(p[1]),
                                          static_cast<double>(p[2])};
        const bool dot = x == dot_x && y == dot_y;
        brightness_off = std::max(brightness_off, std::abs(luma(color) - (dot ? luma({220, 60, 90}) : 100.0) / 255));
        const double red = color[0] - luma(color);
        for (int k = 0; k < 3; ++k) {
          along[static_cast<std::size_t>(k)] += red * std::pow(x - dot_x, k);
          across[static_cast<std::size_t>(k)] += red * std::pow(y - dot_y, k);
        }
      }
    }
    CHECK(brightness_off < 1e-6);
    CHECK(std::abs(along[1] / along[0]) < 1e-3);
    CHECK(std::abs(across[1] / across[0]) < 1e-3);
    CHECK(along[2] / along[0] == doctest::Approx(variance).epsilon(1e-3));
    CHECK(across[2] / across[0] == doctest::Approx(variance).epsilon(1e-3));
  }
}

}  // namespace

SMALL_AND_LARGE("colour is blurred beside brightness, within the known surface", check_coarse_color)
SMALL_AND_LARGE("a coloured dot keeps its place and its brightness", check_dot)
