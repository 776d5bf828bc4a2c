// The view drawn as a shutter sees it that stays open while the object moves, against obvious loops.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "holdfast/pose.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

/// Mean over moments of where a pixel's surface is then, in double precision: the point itself is moved and projected.
/// What is seen beyond `rect` is its border. With `light`, colours (premultiplied by coverage) are averaged as squares.
/// `across`: as if it moved as far at right angles.
Planes exposed(const Planes& pixels, const Planes& depth, const Camera& camera, const Rect& rect, const Twist& twist,
               int taps, bool light, bool across) {
  Planes out(pixels.width, pixels.height, 4);
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const double z = depth.get(x, y, 0);
      if (z <= 0) continue;
      const Eigen::Vector3d p(z * (x - camera.cx) / camera.fx, z * (y - camera.cy) / camera.fy, z);
      const Eigen::Vector3d moved = p + 1e-6 * (twist.head<3>() + twist.tail<3>().cross(p));
      Eigen::Vector2d flow = 1e6 * (camera.project(moved) - camera.project(p));
      if (across) flow = Eigen::Vector2d(-flow.y(), flow.x());
      for (int k = 0; k < taps; ++k) {
        const double t = (k + 0.5) / taps - 0.5;
        const double u = std::clamp(x - t * flow.x(), 0.0, rect.width - 1.0);
        const double v = std::clamp(y - t * flow.y(), 0.0, rect.height - 1.0);
        const int left = static_cast<int>(u), top = static_cast<int>(v);
        for (int j = 0; j <= 1; ++j) {
          for (int i = 0; i <= 1; ++i) {
            const double weight = (i ? u - left : 1 - u + left) * (j ? v - top : 1 - v + top) / taps;
            for (int c = 0; c < 4; ++c) {
              const double value = pixels.get(left + i, top + j, c);
              out.at(x, y, c) += weight * (light && c < 3 ? value * value : value);
            }
          }
        }
      }
      const double coverage = out.get(x, y, 3);
      for (int c = 0; c < 3 && light && coverage > 0; ++c) {
        out.at(x, y, c) = coverage * std::sqrt(out.get(x, y, c) / coverage);
      }
    }
  }
  return out;
}

void check_exposure(const Device::Impl& device, Size size, bool light, bool across) {
  const Level level = level_of(size);
  const Camera& camera = level.camera;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes pixels(size.width, size.height, 4), depth(size.width, size.height, 1);
  for (int y = size.height / 8; y < size.height - size.height / 4; ++y) {
    for (int x = size.width / 10; x < size.width - size.width / 6; ++x) {
      depth.at(x, y, 0) = static_cast<float>(0.5 + 0.2 * uniform(random));
      for (int c = 0; c < 3; ++c) pixels.at(x, y, c) = static_cast<float>(uniform(random));
      pixels.at(x, y, 3) = 1;
    }
  }
  Twist twist;  // by some ten pixels, whatever the size
  twist << 3, -2, 5, 4, -6, 10;
  twist /= size.width;
  kernel::hf_exposure exposure{};
  for (int i = 0; i < 3; ++i) {
    exposure.v[i] = static_cast<float>(twist(i));
    exposure.w[i] = static_cast<float>(twist(3 + i));
  }
  exposure.fx = static_cast<float>(camera.fx);
  exposure.fy = static_cast<float>(camera.fy);
  exposure.cx = static_cast<float>(camera.cx);
  exposure.cy = static_cast<float>(camera.cy);
  exposure.taps = 9;
  exposure.light = light ? 1 : 0;
  exposure.across = across ? 1 : 0;
  const cl::Buffer in = upload(device, to_memory(pixels, level)), z = upload(device, to_plane_memory(depth, level)),
                   out = zeroed(device, level, 4);
  cl::Kernel kernel = device.kernel("motion_blur");
  set_arguments(kernel, in, z, level.layout, to_kernel(whole(level)), exposure, out);
  device.enqueue_rows(kernel, level.padded_width, level.padded_height);
  const auto got = download<float>(device, out, level.elements * 4);
  const Planes expected = exposed(pixels, depth, camera, whole(level), twist, exposure.taps, light, across);
  CHECK(largest_difference(got, level, expected) < 2e-4);
  if (size.width > 1) CHECK(largest_difference(got, level, pixels) > 0.3);
}

void check_encoded(const Device::Impl& device, Size size) { check_exposure(device, size, false, false); }
void check_light(const Device::Impl& device, Size size) { check_exposure(device, size, true, false); }
void check_across(const Device::Impl& device, Size size) { check_exposure(device, size, false, true); }

}  // namespace

SMALL_AND_LARGE("motion blur is the mean of the view over the exposure", check_encoded)
SMALL_AND_LARGE("motion blur is the mean of the light over the exposure", check_light)
SMALL_AND_LARGE("blur across the motion is as much at right angles to it", check_across)
