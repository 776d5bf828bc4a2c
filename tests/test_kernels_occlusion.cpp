// The occlusion tests of every pixel against the same in double precision.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>

#include "support/kernel_scene.hpp"
#include "texture/flow_constraints.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

constexpr int kUntouched = SceneOnDevice::kUntouched;

/// Class of a pixel, and whether a float could decide otherwise.
struct Verdict {
  int expected = 0;
  bool counts = false;
  bool close = false;
};

Verdict reference_class(const Scene& scene, const kernel::hf_warp& warp, const kernel::hf_tests& tests, int x, int y,
                        std::array<double, 3>& sample) {
  Verdict verdict;
  sample = {};
  const int state = scene.state(x, y);
  if (state != HF_USED) {
    verdict.expected = state;
    return verdict;
  }
  const double z = scene.depth.get(x, y, 0);
  const Eigen::Vector3d p((x - scene.camera.cx) / scene.camera.fx * z, (y - scene.camera.cy) / scene.camera.fy * z, z);
  Eigen::Matrix<double, 3, 4> D;
  for (int i = 0; i < 12; ++i) D(i / 4, i % 4) = static_cast<double>(warp.d[i]);
  const Eigen::Vector3d q = D * p.homogeneous();
  const double u = warp.still ? x : scene.camera.fx * q.x() / q.z() + scene.camera.cx;
  const double v = warp.still ? y : scene.camera.fy * q.y() / q.z() + scene.camera.cy;
  const double edge = std::min({u - static_cast<double>(warp.min_x), v - static_cast<double>(warp.min_y),
                                static_cast<double>(warp.max_x) - u, static_cast<double>(warp.max_y) - v});
  const double covered = reference::bilinear(scene.frame, u, v, 3) - static_cast<double>(HF_LEAST_COVERAGE);
  verdict.close = (!warp.still && std::abs(edge) < 1e-3) || std::abs(covered) < 1e-3;
  // Sampled from the least coordinates on, up to before the largest.
  if (edge < 0 || u >= static_cast<double>(warp.max_x) || v >= static_cast<double>(warp.max_y)) {
    verdict.expected = HF_UNUSABLE;
    return verdict;
  }
  if (covered < 0) {
    verdict.expected = HF_UNUSABLE;
    return verdict;
  }
  const auto raw = reference::sampled(scene.features, u, v);
  const auto near = [&](double a, double b, double scale) {
    if (std::abs(a - b) < 2e-3 * scale) verdict.close = true;
  };
  bool any = false, rendered_any = false, apart_angle = false, apart = false;
  std::vector<double> strong_v, strong_i;  // the strong channels' gradients, one after another
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double ix = static_cast<double>(warp.turn[0]) * raw[3 + k] + static_cast<double>(warp.turn[1]) * raw[6 + k];
    const double iy = static_cast<double>(warp.turn[2]) * raw[3 + k] + static_cast<double>(warp.turn[3]) * raw[6 + k];
    sample[k] = raw[k];
    const double gain = reference::cell_value(scene.cells, x, y, c);
    const Eigen::Vector2d gv(gain * scene.dx.get(x, y, c), gain * scene.dy.get(x, y, c)), gi(ix, iy);
    const double minimum = std::sqrt(static_cast<double>(tests.gradient_minimum2));
    near(gv.norm(), minimum, minimum);
    near(gi.norm(), minimum, minimum);
    const bool rendered = gv.norm() > minimum, strong = rendered && gi.norm() > minimum;
    any = any || strong;
    rendered_any = rendered_any || rendered;
    const double cosine = std::sqrt(static_cast<double>(tests.angle_cosine2));
    if (strong && tests.angle_together) {
      strong_v.insert(strong_v.end(), {gv.x(), gv.y()});
      strong_i.insert(strong_i.end(), {gi.x(), gi.y()});
    } else if (strong) {
      near(gv.dot(gi), cosine * gv.norm() * gi.norm(), gv.norm() * gi.norm());
      near(gv.dot(gi), 0, gv.norm() * gi.norm());
      if (std::acos(std::clamp(gv.dot(gi) / (gv.norm() * gi.norm()), -1.0, 1.0)) > std::acos(cosine))
        apart_angle = true;
    }
    const double limit = static_cast<double>(tests.difference_maximum) +
                         static_cast<double>(tests.difference_relative) * std::max(gv.norm(), gi.norm());
    const double difference = (gv - gi).norm();
    near(difference, limit, limit);
    apart = apart || difference >= limit;
  }
  if (!strong_v.empty()) {
    const auto count = static_cast<Eigen::Index>(strong_v.size());
    const Eigen::VectorXd all_v = Eigen::Map<Eigen::VectorXd>(strong_v.data(), count);
    const Eigen::VectorXd all_i = Eigen::Map<Eigen::VectorXd>(strong_i.data(), count);
    const double cosine = all_v.dot(all_i) / (all_v.norm() * all_i.norm());
    const double least = std::sqrt(static_cast<double>(tests.angle_cosine2));
    near(cosine, least, 1);
    near(cosine, 0, 1);
    apart_angle = cosine < least;
  }
  verdict.expected = HF_USED;
  if (tests.magnitude_test && apart) verdict.expected = HF_REJECTED_MAGNITUDE;
  if (tests.angle_test && apart_angle) verdict.expected = HF_REJECTED_ANGLE;
  if (tests.gradient_test && !any) verdict.expected = HF_NO_GRADIENT;
  verdict.counts = rendered_any || (tests.magnitude_test && apart);
  return verdict;
}

void check_occlusion_tests(const Device::Impl& device, Size size) {
  const Scene scene(size, 21);
  const SceneOnDevice on_device(device, scene);
  kernel::hf_warp warp = small_warp(scene, size.width > 100 ? 0.01 : 1.0);
  for (int variant = 0; variant < 8; ++variant) {
    CAPTURE(variant);
    OcclusionOptions options;
    options.magnitude_test = variant != 1 && variant != 4;
    options.angle_together = variant != 7;
    if (variant == 2) options.difference_relative = 0;
    if (variant == 3) options.angle_test = false;
    if (variant == 4) options.gradient_test = false;
    if (variant == 6) warp = small_warp(scene, 0);
    CHECK(warp.still == (variant >= 6));
    warp.every = variant == 5 ? 3 : 1;
    const kernel::hf_tests tests = make_tests(options);
    on_device.clear();
    on_device.run_tests(warp, tests);
    const auto classes = on_device.classes();
    const auto samples = on_device.samples();
    int wrong = 0, close = 0;
    double largest = 0;
    std::array<int, 16> seen{};
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        std::array<double, HF_SAMPLES> sample{};
        const Verdict verdict =
            y % warp.every == 0 ? reference_class(scene, warp, tests, x, y, sample) : Verdict{kUntouched, false, false};
        const auto e = element(scene.level, x, y);
        ++seen[static_cast<std::size_t>(classes[e] & 15)];
        if (verdict.expected == kUntouched) {
          if (classes[e] != kUntouched) ++wrong;
          continue;
        }
        if (verdict.close) {
          ++close;
          continue;
        }
        if ((classes[e] & 15) != verdict.expected || (classes[e] >> 4 != 0) != verdict.counts) ++wrong;
        if (verdict.expected < HF_NO_GRADIENT) continue;
        for (std::size_t c = 0; c < HF_SAMPLES; ++c) {
          largest = std::max(largest, std::abs(static_cast<double>(samples[e + c * scene.level.elements]) - sample[c]));
        }
      }
    }
    CHECK(wrong == 0);
    CHECK(largest < 2e-4);
    CHECK(close <= 1 + size.width * size.height / 20);
    if (size.width > 100) {  // the scene exercises every outcome
      for (const int outcome : {HF_NOT_VISIBLE, HF_UNUSABLE, HF_USED})
        CHECK(seen[static_cast<std::size_t>(outcome)] > 0);
      if (variant == 0) {
        for (const int outcome : {HF_NO_GRADIENT, HF_REJECTED_ANGLE, HF_REJECTED_MAGNITUDE}) {
          CHECK(seen[static_cast<std::size_t>(outcome)] > 50);
        }
      }
    }
  }
}

}  // namespace

SMALL_AND_LARGE("occlusion tests", check_occlusion_tests)
