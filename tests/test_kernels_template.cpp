// What the rendered view becomes: pixels and depth, planes of values and differences, usability.
#include <doctest/doctest.h>

#include <random>

#include "image/template_planes.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

void check_view_template(const Device::Impl& device, Size size) {
  Camera camera{size.width, size.height, 100, 100, 0, 0, {}};
  const auto levels = make_levels(camera, 2);
  const Level& level = levels[0];
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  const int stride = level.padded_width + 3;
  constexpr std::size_t guard = HF_RENDER_GUARD;
  std::vector<std::uint8_t> rgba((static_cast<std::size_t>(stride * level.padded_height) + 2 * guard) * 4, 0);
  std::vector<float> window(static_cast<std::size_t>(stride * level.padded_height), 1.0f);
  const double near_plane = 0.5, far_plane = 0.9;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto i = static_cast<std::size_t>(y * stride + x);
      for (std::size_t c = 0; c < 3; ++c) rgba[4 * (guard + i) + c] = static_cast<std::uint8_t>(random());
      rgba[4 * (guard + i) + 3] = uniform(random) < 0.2 ? 0 : 255;
      if (uniform(random) < 0.8) window[i] = static_cast<float>(0.95 * uniform(random));
    }
  }
  for (const int grey : {0, 1}) {
    const cl::Buffer rgba_buffer = upload(device, rgba), window_buffer = upload(device, window);
    const cl::Buffer pixels = zeroed(device, level, 4);
    const cl::Buffer depth = zeroed(device, level);
    kernel::hf_view view{stride, grey, static_cast<float>(near_plane), static_cast<float>(far_plane)};
    cl::Kernel unpack = device.kernel("unpack_view");
    set_arguments(unpack, rgba_buffer, window_buffer, view, to_kernel(whole(level)), level.layout, pixels, depth);
    device.enqueue_rows(unpack, level.padded_width, level.padded_height);
    Planes expected(size.width, size.height, 4), z(size.width, size.height, 1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const auto i = static_cast<std::size_t>(y * stride + x);
        const double d = static_cast<double>(window[i]);
        if (d >= 1) continue;
        z.at(x, y, 0) = near_plane * far_plane / (far_plane - d * (far_plane - near_plane));
        if (rgba[4 * (guard + i) + 3] == 0) continue;
        for (int c = 0; c < 3; ++c) expected.at(x, y, c) = rgba[4 * (guard + i) + static_cast<std::size_t>(c)] / 255.0;
        if (grey) {
          const double luma =
              0.299 * expected.get(x, y, 0) + 0.587 * expected.get(x, y, 1) + 0.114 * expected.get(x, y, 2);
          expected.at(x, y, 0) = luma;
          expected.at(x, y, 1) = expected.at(x, y, 2) = 0;
        }
        expected.at(x, y, 3) = 1;
      }
    }
    CHECK(largest_difference(download<float>(device, pixels, level.elements * 4), level, expected) < 1e-6);
    CHECK(largest_difference(download<float>(device, depth, level.elements), level, z) < 1e-6);
    const cl::Buffer depth_alone = zeroed(device, level);
    cl::Kernel unpack_depth = device.kernel("unpack_depth");
    set_arguments(unpack_depth, window_buffer, view, to_kernel(whole(level)), level.layout, depth_alone);
    device.enqueue_rows(unpack_depth, level.padded_width, level.padded_height);
    CHECK(largest_difference(download<float>(device, depth_alone, level.elements), level, z) < 1e-6);

    const cl::Buffer half = zeroed(device, levels[1]);
    cl::Kernel halve = device.kernel("halve_depth");
    set_arguments(halve, depth, level.layout, to_kernel(whole(levels[1])), levels[1].layout, half);
    device.enqueue_rows(halve, levels[1].padded_width, levels[1].padded_height);
    Planes half_expected(levels[1].width, levels[1].height, 1);
    for (int y = 0; y < half_expected.height; ++y) {
      for (int x = 0; x < half_expected.width; ++x) {
        double sum = 0, count = 0;
        for (int j = 0; j <= 1; ++j) {
          for (int i = 0; i <= 1; ++i) {
            const double one = z.get(2 * x + i, 2 * y + j, 0);
            sum += one;
            count += one > 0;
          }
        }
        half_expected.at(x, y, 0) = count > 0 ? sum / count : 0;
      }
    }
    CHECK(largest_difference(download<float>(device, half, levels[1].elements), levels[1], half_expected) < 1e-6);
  }
}

constexpr float kLeastCoverage = 0.85f, kDepthJump = 0.02f;  // a share of the depth
constexpr int kReach = 2;                                    // pixels within which a jump spoils

/// Whether a pixel's template may be compared, from its own and its neighbours' coverage and depth; where `bend` is not
/// 0, also from how much the inverse depth bends.
int usability(const Planes& in, const Planes& depth, int x, int y, double bend) {
  const double z = depth.get(x, y, 0);
  if (z <= 0) return HF_NOT_VISIBLE;
  bool good = in.get(x, y, 3) >= static_cast<double>(kLeastCoverage);
  const int neighbours[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& n : neighbours) {
    good = good && in.get(x + n[0], y + n[1], 3) > 0.25;
    for (int k = 1; k <= kReach; ++k) {
      const double other = depth.get(x + k * n[0], y + k * n[1], 0);
      good = good && other > 0 && std::abs(other - z) <= static_cast<double>(kDepthJump) * z;
    }
    for (const int k : {1, 3}) {
      const double before = depth.get(x - k * n[0], y - k * n[1], 0);
      const double after = depth.get(x + k * n[0], y + k * n[1], 0);
      if (bend > 0 && before > 0 && after > 0 && std::abs(z / before + z / after - 2) > bend) good = false;
    }
  }
  return good ? HF_USED : HF_UNUSABLE;
}

/// Levels of depth far from the jump's limit, and holes; nothing outside of a disc, as around an object.
Planes random_depth(Size size) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes depth(size.width, size.height, 1);
  for (double& z : depth.values) {
    z = uniform(random) < 0.1 ? 0.0 : uniform(random) < 0.1 ? 0.7f : uniform(random) < 0.1 ? 0.605f : 0.6f;
  }
  const double radius = 0.4 * std::max(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (std::hypot(x - 0.4 * size.width, y - 0.6 * size.height) > radius) depth.at(x, y, 0) = 0;
    }
  }
  return depth;
}

struct DevicePlanes {
  cl::Buffer value, dx, dy, usable;
  DevicePlanes(const Device::Impl& device, const Level& level) : usable(zeroed<std::uint8_t>(device, level)) {
    for (cl::Buffer* planes : {&value, &dx, &dy}) {
      *planes = device.zeroed_buffer((level.elements * 3 + kGuardFloats) * sizeof(float));
    }
  }
  TemplatePlanes::Out out() const { return {value, dx, dy, usable}; }
};

kernel::hf_template limits_of(const Level& level, float bend) {
  return {level.width, level.height, static_cast<int>(level.elements), kLeastCoverage, kDepthJump, kReach, bend};
}

/// An image in all of the level's memory that is filtered, which its blur reaches beyond the image.
Planes padded(const Planes& image, const Level& level) {
  Planes out(level.padded_width, level.padded_height, image.channels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) out.at(x, y, c) = image.get(x, y, c);
    }
  }
  return out;
}

/// Against the blurred and normalised pixels that they should be made of.
void check_planes(const Device::Impl& device, const Level& level, const DevicePlanes& planes, const Planes& in,
                  const Planes& depth, float bend, int left = 0, int top = 0) {
  const auto got_value = download<float>(device, planes.value, level.elements * 3);
  const auto got_dx = download<float>(device, planes.dx, level.elements * 3);
  const auto got_dy = download<float>(device, planes.dy, level.elements * 3);
  const auto got_usable = download<std::uint8_t>(device, planes.usable, level.elements);
  double largest = 0;
  int wrong = 0, near_limit = 0;
  for (int y = top; y < depth.height; ++y) {
    for (int x = left; x < depth.width; ++x) {
      const auto e = element(level, x, y);
      // Coverages are sums of floats.
      double nearest = std::abs(in.get(x, y, 3) - static_cast<double>(kLeastCoverage));
      for (const auto& [i, j] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        nearest = std::min(nearest, std::abs(in.get(x + i, y + j, 3) - 0.25));
      }
      if (nearest < 1e-6) {
        ++near_limit;
      } else if (got_usable[e] != usability(in, depth, x, y, static_cast<double>(bend))) {
        ++wrong;
      }
      if (depth.get(x, y, 0) <= 0) continue;  // nothing reads the planes there
      const bool at_rim = x == left || y == top || x == in.width - 1 || y == in.height - 1;
      if (at_rim && got_usable[e] == HF_UNUSABLE) continue;  // nor there: a neighbour lies outside
      for (int c = 0; c < 3; ++c) {
        const auto i = e + static_cast<std::size_t>(c) * level.elements;
        const double wanted_dx = (in.get(x + 1, y, c) - in.get(x - 1, y, c)) / 2;
        const double wanted_dy = (in.get(x, y + 1, c) - in.get(x, y - 1, c)) / 2;
        largest = std::max({largest, std::abs(static_cast<double>(got_value[i]) - in.get(x, y, c)),
                            std::abs(static_cast<double>(got_dx[i]) - wanted_dx),
                            std::abs(static_cast<double>(got_dy[i]) - wanted_dy)});
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(near_limit <= 0.001 * depth.width * depth.height);
  CHECK(largest < 2e-5);
}

void check_template_planes(const Device::Impl& device, Size size, float bend) {
  const Level level = level_of(size);
  const Planes in = random_pixels(size, 3), depth = random_depth(size);
  const cl::Buffer in_buffer = upload(device, to_memory(in, level)),
                   depth_buffer = upload(device, to_plane_memory(depth, level));
  ImageFilter filter(device);
  TemplatePlanes template_planes(device, filter, level);
  const DevicePlanes planes(device, level);
  template_planes.enqueue(in_buffer, {}, depth_buffer, level, whole(level), limits_of(level, bend), planes.out());
  check_planes(device, level, planes, reference::blurred(padded(in, level), ImageFilter::kSigma), depth, bend);
}

/// Strips make the planes of a render as it comes.
void check_render_planes(const Device::Impl& device, Size size) {
  if (!device.strips) return;
  const Level level = level_of(size);
  const Planes depth = random_depth(size);
  const cl::Buffer depth_buffer = upload(device, to_plane_memory(depth, level));
  // One tile smaller than the picture on the left and at the top, where there is more than one.
  const int left = level.padded_width > HF_TILE ? HF_TILE : 0, top = level.padded_height > HF_TILE ? HF_TILE : 0;
  const Rect rect{left, top, level.padded_width - left, level.padded_height - top};
  std::mt19937 random(6);
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(rect.width * rect.height + 2 * HF_RENDER_GUARD) * 4);
  for (auto& byte : rgba) byte = static_cast<std::uint8_t>(random());
  for (const int grey : {0, 1}) {
    Planes pixels(level.padded_width, level.padded_height, 4);
    for (int y = rect.y; y < level.padded_height; ++y) {
      for (int x = rect.x; x < level.padded_width; ++x) {
        std::uint8_t* pixel =
            rgba.data() + 4 * static_cast<std::size_t>(HF_RENDER_GUARD + (y - rect.y) * rect.width + x - rect.x);
        if (grey == 0) pixel[3] = random() % 4 == 0 ? 0 : 255;
        if (pixel[3] == 0) continue;
        const double red = pixel[0] / 255.0, green = pixel[1] / 255.0, blue = pixel[2] / 255.0;
        pixels.at(x, y, 0) = grey ? 0.299 * red + 0.587 * green + 0.114 * blue : red;
        pixels.at(x, y, 1) = grey ? 0 : green;
        pixels.at(x, y, 2) = grey ? 0 : blue;
        pixels.at(x, y, 3) = 1;
      }
    }
    const cl::Buffer packed = upload(device, rgba);
    const kernel::hf_view view{rect.width, grey, 0.5f, 0.9f};
    ImageFilter filter(device);
    TemplatePlanes template_planes(device, filter, level);
    const DevicePlanes planes(device, level);
    template_planes.enqueue(packed, view, depth_buffer, level, rect, limits_of(level, 0.004f), planes.out());
    // Nothing is made of what lies outside.
    Planes expected = reference::blurred(pixels, ImageFilter::kSigma);
    for (int y = 0; y < level.padded_height; ++y) {
      for (int x = 0; x < level.padded_width; ++x) {
        if (x >= left && y >= top) continue;
        for (int c = 0; c < 4; ++c) expected.at(x, y, c) = 0;
      }
    }
    check_planes(device, level, planes, expected, depth, 0.004f, left, top);
  }
}

void check_template_planes_kept(const Device::Impl& device, Size size) { check_template_planes(device, size, 0.0f); }
void check_template_planes_bent(const Device::Impl& device, Size size) { check_template_planes(device, size, 0.004f); }

}  // namespace

SMALL_AND_LARGE("unpacking and halving the view", check_view_template)
SMALL_AND_LARGE("template planes and usability", check_template_planes_kept)
SMALL_AND_LARGE("template planes of a render as it comes", check_render_planes)
SMALL_AND_LARGE("template planes away from edges between faces", check_template_planes_bent)
