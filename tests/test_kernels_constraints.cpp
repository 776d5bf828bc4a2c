// Vote, flow constraints and their sums against obvious loops; the flow row against central differences.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstring>

#include "support/kernel_scene.hpp"
#include "texture/flow_constraints.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

kernel::hf_constraints constraints_of(const Scene& scene, int variant) {
  kernel::hf_constraints k{};
  k.center[0] = 0.01f;
  k.center[1] = -0.02f;
  k.center[2] = 0.65f;
  k.radius = 0.12f;
  k.fx = static_cast<float>(scene.camera.fx);
  k.fy = static_cast<float>(scene.camera.fy);
  k.cx = static_cast<float>(scene.camera.cx);
  k.cy = static_cast<float>(scene.camera.cy);
  k.block_vote = variant != 1;
  k.vote_radius = variant == 3 ? 2 : 4;
  k.vote_share = 0.6180f;  // no count times it is a whole number: no ties to round
  k.robust = variant != 1;
  k.inverse_scale2 = 1 / (0.03f * 0.03f);
  k.freedom = 4;
  k.redundancy = variant == 2 || variant == 6;
  k.redundancy_cosine2 = 0.81f;
  k.gradient_minimum2 = 0.01f * 0.01f;
  k.every = variant == 4 ? 3 : 1;
  k.elimination = variant != 3;
  k.saturated = variant == 5 ? 0.55f : 2.0f;
  return k;
}

/// What the kernel sums over the image, and the same of absolute values, which bound its rounding.
struct Sums {
  Matrix6 A = Matrix6::Zero(), A_size = Matrix6::Zero();
  Twist h = Twist::Zero(), h_size = Twist::Zero();
  double square = 0, weight = 0, rows = 0, used = 0, visible = 0, gradient = 0, passed = 0;
  std::array<double, HF_CELL_SUMS> cells{}, cells_size{};
};

/// The vote and the sums, a pixel after another, from the classes and samples that the tests wrote.
class Reference {
 public:
  Reference(const Scene& scene, const kernel::hf_constraints& k, const std::vector<std::uint8_t>& classes,
            const std::vector<float>& samples)
      : scene_(scene), k_(k), classes_(classes), samples_(samples) {}

  int class_at(int x, int y) const {
    if (x < 0 || y < 0 || x >= scene_.size.width || y >= scene_.size.height) return 0;
    return classes_[element(scene_.level, x, y)];
  }

  int voted(int x, int y) const {
    const int own = class_at(x, y) & 15;
    if (own != HF_USED || !k_.block_vote) return own;
    double counted = 0, agreed = 0;
    for (int j = -k_.vote_radius; j <= k_.vote_radius; ++j) {
      if ((y + j) % k_.every != 0) continue;
      for (int i = -k_.vote_radius; i <= k_.vote_radius; ++i) {
        const int other = class_at(x + i, y + j);
        counted += other >> 4;
        agreed += (other >> 4) && (other & 15) == HF_USED;
      }
    }
    return agreed < static_cast<double>(k_.vote_share) * counted ? HF_REJECTED_VOTE : own;
  }

  void add(Sums& sums, int x, int y) const {
    ++sums.used;
    sums.cells[HF_CELL_PIXELS] += 1;
    sums.cells[HF_CELL_DEPTH] += scene_.depth.get(x, y, 0);
    std::array<Eigen::Vector2d, 3> gv;
    std::array<double, 3> r{}, seen{};
    std::size_t strongest = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const int channel = static_cast<int>(c);
      const double gain = reference::cell_value(scene_.cells, x, y, channel);
      const double bias = reference::cell_value(scene_.cells, x, y, 3 + channel);
      seen[c] = sample(x, y, c);
      gv[c] = gain * Eigen::Vector2d(scene_.dx.get(x, y, channel), scene_.dy.get(x, y, channel));
      r[c] = gain * scene_.value.get(x, y, channel) + bias - seen[c];
      if (gv[c].norm() > gv[strongest].norm()) strongest = c;
    }
    const std::vector<std::size_t> leading =
        k_.redundancy ? leading_channels(gv, strongest) : std::vector<std::size_t>{0, 1, 2};
    for (std::size_t c = 0; c < 3; ++c) {
      const bool leads = std::find(leading.begin(), leading.end(), c) != leading.end();
      const Eigen::Vector2d g = leads ? gv[c] : along(gv[c], gv[nearest(gv, leading, c)]);
      const double unclipped_weight = k_.robust ? 5.0 / (4.0 + r[c] * r[c] / (0.03 * 0.03)) : 1.0;
      const double weight = seen[c] < static_cast<double>(k_.saturated) ? unclipped_weight : 0.0;
      add_moments(sums, c, weight, scene_.value.get(x, y, static_cast<int>(c)), seen[c], r[c], g);
      add_row(sums, x, y, weight, r[c], g, leads);
    }
  }

 private:
  static double sine(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::abs(a.x() * b.y() - a.y() * b.x()) / std::max(1e-30, a.norm() * b.norm());
  }

  static Eigen::Vector2d along(const Eigen::Vector2d& g, const Eigen::Vector2d& direction) {
    return direction * (direction.dot(g) / std::max(1e-30, direction.squaredNorm()));
  }

  /// The strongest channel, and the strongest of those whose gradient points elsewhere and is one.
  static std::vector<std::size_t> leading_channels(const std::array<Eigen::Vector2d, 3>& gv, std::size_t strongest) {
    std::vector<std::size_t> leading{strongest};
    for (std::size_t c = 0; c < 3; ++c) {
      if (c == strongest || gv[c].norm() <= 0.01 || sine(gv[c], gv[strongest]) < std::sqrt(1 - 0.81)) continue;
      if (leading.size() == 1) leading.push_back(c);
      if (gv[c].norm() > gv[leading[1]].norm()) leading[1] = c;
    }
    return leading;
  }

  static std::size_t nearest(const std::array<Eigen::Vector2d, 3>& gv, const std::vector<std::size_t>& leading,
                             std::size_t c) {
    return leading.size() == 2 && sine(gv[c], gv[leading[1]]) < sine(gv[c], gv[leading[0]]) ? leading[1] : leading[0];
  }

  double sample(int x, int y, std::size_t plane) const {
    return static_cast<double>(samples_[element(scene_.level, x, y) + plane * scene_.level.elements]);
  }

  void add_moments(Sums& sums, std::size_t channel, double weight, double v, double seen, double r,
                   const Eigen::Vector2d& g) const {
    const std::array<double, HF_PHOTO> moments{
        weight,     weight * v,     weight * seen,  weight * v * v, weight * seen * seen, weight * v * seen,
        weight * r, weight * v * r, weight * g.x(), weight * g.y(), weight * v * g.x(),   weight * v * g.y()};
    for (std::size_t i = 0; i < (k_.elimination ? HF_PHOTO : 6); ++i) {
      sums.cells[channel * HF_PHOTO + i] += moments[i];
      sums.cells_size[channel * HF_PHOTO + i] += std::abs(moments[i]);
    }
  }

  void add_row(Sums& sums, int x, int y, double weight, double r, const Eigen::Vector2d& g, bool leads) const {
    const Eigen::Vector3d center(static_cast<double>(k_.center[0]), static_cast<double>(k_.center[1]),
                                 static_cast<double>(k_.center[2]));
    const Twist row = reference::flow_row(scene_.camera, x, y, scene_.depth.get(x, y, 0), g.x(), g.y(), center,
                                          static_cast<double>(k_.radius));
    if (leads) {
      ++sums.rows;
      sums.weight += weight;
      sums.square += weight * r * r;
    }
    sums.A += weight * row * row.transpose();
    sums.h += weight * row * r;
    sums.A_size += weight * (row * row.transpose()).cwiseAbs();
    sums.h_size += weight * (row * r).cwiseAbs();
  }

  const Scene& scene_;
  const kernel::hf_constraints& k_;
  const std::vector<std::uint8_t>& classes_;
  const std::vector<float>& samples_;
};

/// The tiles' sums, added, against the reference's.
void check_sums(const std::vector<float>& tiles, const Sums& expected, bool redundancy) {
  std::array<double, HF_SUM_MAIN> got{};
  std::array<double, HF_CELL_SUMS> got_cells{};
  for (std::size_t t = 0; t < tiles.size() / HF_SUM_STRIDE; ++t) {
    for (std::size_t i = 0; i < HF_SUM_MAIN; ++i) got[i] += static_cast<double>(tiles[t * HF_SUM_STRIDE + i]);
    for (std::size_t i = 0; i < 4 * HF_CELL_SUMS; ++i) {
      got_cells[i % HF_CELL_SUMS] += static_cast<double>(tiles[t * HF_SUM_STRIDE + HF_SUM_PHOTO + i]);
    }
  }
  // A row may be counted on one side only where a cosine is within rounding of the redundancy limit.
  const double row_tolerance = redundancy ? 2e-3 : 1e-5;
  CHECK(std::abs(got[HF_SUM_ROWS] - expected.rows) <= (redundancy ? 3 : 0));
  CHECK(got[HF_SUM_USED] == expected.used);
  CHECK(got[HF_SUM_VISIBLE] == expected.visible);
  CHECK(got[HF_SUM_GRADIENT] == expected.gradient);
  CHECK(got[HF_SUM_PASSED] == expected.passed);
  CHECK(std::abs(got[HF_SUM_WRR] - expected.square) <= row_tolerance * expected.square + 1e-9);
  CHECK(std::abs(got[HF_SUM_W] - expected.weight) <= row_tolerance * expected.weight + 1e-9);
  std::size_t n = HF_SUM_A;
  double worst = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      worst = std::max(worst, std::abs(got[n++] - expected.A(i, j)) / (expected.A_size(i, j) + 1e-9));
    }
    const double h = got[static_cast<std::size_t>(HF_SUM_H + i)];
    worst = std::max(worst, std::abs(h - expected.h(i)) / (expected.h_size(i) + 1e-9));
  }
  CHECK(worst < 2 * row_tolerance);
  double worst_cell = 0;
  for (std::size_t i = 0; i < HF_CELL_SUMS; ++i) {
    const bool positive = i == HF_CELL_PIXELS || i == HF_CELL_DEPTH;
    const double size = positive ? expected.cells[i] : expected.cells_size[i];
    worst_cell = std::max(worst_cell, std::abs(got_cells[i] - expected.cells[i]) / (size + 1e-9));
  }
  CHECK(worst_cell < 2e-5);
}

void check_flow_constraints(const Device::Impl& device, Size size) {
  const Scene scene(size, 33);
  const SceneOnDevice on_device(device, scene);
  on_device.run_tests(small_warp(scene, 0.01), make_tests({.magnitude_test = true}));
  const auto classes = on_device.classes();
  const auto samples = on_device.samples();
  for (int variant = 0; variant < 7; ++variant) {
    CAPTURE(variant);
    const kernel::hf_constraints k = constraints_of(scene, variant);
    const auto tiles = on_device.run_constraints(k);
    const auto final_classes = on_device.final_classes();
    const Reference reference(scene, k, classes, samples);
    Sums expected;
    int class_errors = 0, outvoted = 0;
    for (int y = 0; y < size.height; y += k.every) {
      for (int x = 0; x < size.width; ++x) {
        const int tested = reference.class_at(x, y), voted = reference.voted(x, y);
        expected.visible += (tested & 15) != 0;
        expected.gradient += tested >> 4;
        expected.passed += (tested & 15) == HF_USED;
        class_errors += final_classes[element(scene.level, x, y)] != voted;
        outvoted += voted == HF_REJECTED_VOTE;
        if (voted == HF_USED) reference.add(expected, x, y);
      }
    }
    CHECK(class_errors == 0);
    check_sums(tiles, expected, k.redundancy != 0);
    if (size.width > 100) {
      CHECK(expected.used > 1000);
      if (k.block_vote) CHECK(outvoted > 100);
    }
    // The same bits again.
    const auto again = on_device.run_constraints(k);
    CHECK(std::memcmp(tiles.data(), again.data(), tiles.size() * sizeof(float)) == 0);
  }
}

}  // namespace

SMALL_AND_LARGE("vote, flow constraints and their sums", check_flow_constraints)

TEST_CASE("the flow row is the derivative of intensity along all six axes") {
  // A smooth image on a surface; fx != fy, principal point off centre. Intensity at the projection of exp(xi) P, by
  // central differences, against the row.
  const reference::Camera camera{611, 587, 201.3, 131.7};
  const Eigen::Vector3d center(0.03, -0.02, 0.71);
  const double radius = 0.11;
  const auto image = [](double x, double y) {
    return 0.5 + 0.2 * std::sin(0.11 * x + 0.05 * y) + 0.1 * std::cos(0.07 * y - 0.02 * x);
  };
  const auto slope = [](double x, double y) {
    return Eigen::Vector2d(0.2 * 0.11 * std::cos(0.11 * x + 0.05 * y) + 0.1 * 0.02 * std::sin(0.07 * y - 0.02 * x),
                           0.2 * 0.05 * std::cos(0.11 * x + 0.05 * y) - 0.1 * 0.07 * std::sin(0.07 * y - 0.02 * x));
  };
  for (const auto& [x, y, z] :
       {std::array{37.0, 92.0, 0.66}, std::array{310.0, 40.0, 0.75}, std::array{201.3, 131.7, 0.7}}) {
    const Eigen::Vector3d p((x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z);
    const Eigen::Vector2d g = slope(x, y);
    const Twist row = reference::flow_row(camera, x, y, z, g.x(), g.y(), center, radius);
    for (int axis = 0; axis < 6; ++axis) {
      const double step = 1e-5;
      const auto intensity = [&](double amount) {
        // A conditioned motion: translation in radii, rotation about the centre (by the rotation's own formula).
        Eigen::Vector3d moved = p;
        if (axis < 3) {
          moved += radius * amount * Eigen::Vector3d::Unit(axis);
        } else {
          moved = center + Eigen::AngleAxisd(amount, Eigen::Vector3d::Unit(axis - 3)) * (p - center);
        }
        return image(camera.fx * moved.x() / moved.z() + camera.cx, camera.fy * moved.y() / moved.z() + camera.cy);
      };
      const double numeric = (intensity(step) - intensity(-step)) / (2 * step);
      CHECK(row(axis) == doctest::Approx(numeric).epsilon(1e-6).scale(1e-3));
    }
  }
}
