// How well the frame agrees with the view at every shift of it, against a sum over the image.
#include <doctest/doctest.h>

#include "support/kernel_scene.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

void check_shift_scores(const Device::Impl& device, Size size) {
  const Scene scene(size, 55);
  // A step of 3 on large images: llvmpipe ends all loops of a kernel after 65535 passes.
  const Rect shifts = size.width > 100 ? Rect{-2, -1, 5, 3} : Rect{-9, -7, 21, 16};
  const int step = size.width > 100 ? 3 : 2;
  const auto got = SceneOnDevice(device, scene).run_shift_scores(shifts, step);
  for (int sy = shifts.y; sy < shifts.y + shifts.height; ++sy) {
    for (int sx = shifts.x; sx < shifts.x + shifts.width; ++sx) {
      double agreement = 0, weight = 0;
      for (int y = 0; y < size.height; y += step) {
        for (int x = 0; x < size.width; x += step) {
          if (scene.state(x, y) != HF_USED) continue;
          double vv = 0, ii = 0, vi = 0;
          const int u = x + sx, v = y + sy;
          for (int c = 0; c < 3; ++c) {
            const double vx = scene.dx.get(x, y, c), vy = scene.dy.get(x, y, c);
            const double ix = scene.features.get(u, v, 3 + c), iy = scene.features.get(u, v, 6 + c);
            vv += vx * vx + vy * vy;
            ii += ix * ix + iy * iy;
            vi += vx * ix + vy * iy;
          }
          if (vv < 1e-5) continue;
          weight += std::sqrt(vv);
          if (u < 1 || v < 1 || u > size.width - 2 || v > size.height - 2) continue;
          agreement += std::sqrt(vv) * vi / (0.5 * (vv + ii) + 1e-5);
        }
      }
      const double expected = weight > 0 ? agreement / weight : 0;
      CHECK(static_cast<double>(got[static_cast<std::size_t>((sy - shifts.y) * shifts.width + sx - shifts.x)]) ==
            doctest::Approx(expected).epsilon(1e-3).scale(0.1));
    }
  }
}

}  // namespace

SMALL_AND_LARGE("shift scores", check_shift_scores)
