// What the contour says of a pose: against central differences and synthetic pictures, whatever does the same to every
// edge.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "contour/contour_modality.hpp"
#include "device/device_impl.hpp"
#include "simulation/textured_box.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;

const Camera kCamera{323, 241, 402, 391, 160.3, 118.7, {}};

Pose turned_box_pose() { return test::pose_at({0.02, -0.015, 0.9}, {0.4, 0.5, 0.2}); }

/// Sums as if lines all round a disc of this radius, pixels, found their edges `off` pixels out, all with this weight.
ContourSums disc_sums(const std::function<double(double)>& off, double weight, int lines = 200) {
  ContourSums sums;
  constexpr double kPixels = 60;  // an object's radius
  for (int i = 0; i < lines; ++i) {
    const double angle = 2 * std::numbers::pi * i / lines;
    // How far the line's pixel moves with the perturbation: sideways, nearer, tipped (of a disc that is thick), turned.
    Twist row;
    row << kPixels * std::cos(angle), kPixels * std::sin(angle), 0.3 * kPixels, 20 * std::sin(2 * angle),
        20 * std::cos(3 * angle), 8 * std::sin(4 * angle);
    const double d = off(angle);
    sums.A += weight * row * row.transpose();
    sums.h += weight * d * row;
    sums.outward += weight * row;
    sums.weighted_square += weight * d * d;
    sums.weight += weight;
    sums.weighted_distance += weight * d;
    ++sums.lines;
    ++sums.rows;
    ++sums.near;
  }
  return sums;
}

Twist step_of(const ContourSums& sums) {
  const NormalEquations equations = contour_equations(sums, Pose::Identity());
  return equations.A.ldlt().solve(equations.h);
}

/// The same sums, as if no edge could be off like all others.
ContourSums without_common_shift(ContourSums sums) {
  sums.outward.setZero();
  sums.weighted_distance = 0;
  return sums;
}

/// The step beside what is known anyway, to a hundredth.
Twist step_beside_prior(const ContourSums& sums) {
  const NormalEquations equations = contour_equations(sums, Pose::Identity());
  return (equations.A + 1e4 * Matrix6::Identity()).ldlt().solve(equations.h);
}

/// A frame of a shape of one colour before another, as it is drawn from a pose.
struct PaintedFrame {
  PaintedFrame(const Device& device, const Mesh& mesh, const Pose& T)
      : filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), kCamera, levels, filter),
        extent{mesh.center().cast<double>(), mesh.radius()},
        shape(levels, extent, view),
        contour(device.impl(), levels, extent, view, shape, image) {
    const Rect whole{0, 0, kCamera.width, kCamera.height};
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(kCamera.width * kCamera.height) * 4);
    // Four pixels a side of each are averaged, so that edges are where they are.
    constexpr int kFine = 4;
    Camera fine = kCamera;
    fine.width *= kFine;
    fine.height *= kFine;
    fine.fx *= kFine;
    fine.fy *= kFine;
    fine.cx = kFine * (kCamera.cx + 0.5) - 0.5;
    fine.cy = kFine * (kCamera.cy + 0.5) - 0.5;
    Renderer renderer(mesh, fine.width, fine.height);
    const test::View drawn = test::draw(renderer, T, fine);
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        int hits = 0;
        for (int n = 0; n < kFine * kFine; ++n) hits += drawn.drawn(kFine * x + n % kFine, kFine * y + n / kFine);
        const double share = static_cast<double>(hits) / (kFine * kFine);
        const std::array<double, 3> object{200, 90, 40}, background{60, 110, 170};
        std::uint8_t* pixel = rgba.data() + 4 * static_cast<std::size_t>(y * kCamera.width + x);
        for (std::size_t c = 0; c < 3; ++c) {
          pixel[c] = static_cast<std::uint8_t>(std::lround(share * object[c] + (1 - share) * background[c]));
        }
        pixel[3] = 255;
      }
    }
    image.enqueue_upload(ImageView{rgba.data(), kCamera.width, kCamera.height, 0, PixelFormat::rgba8},
                         image.region(whole));
    image.wait_for_upload();
    REQUIRE(contour.learn(T, 0, colors));
    contour.use_colors(colors);
  }

  std::vector<Level> levels = make_levels(kCamera, 3);
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  Extent extent;
  DepthView shape;
  ContourModality contour;
  ColorHistograms colors;
};

}  // namespace

TEST_CASE("what lines say of a motion is how far it moves the contour: its gradient by central differences") {
  const Mesh mesh = simulation::textured_box();
  const Device device;
  const Pose T = turned_box_pose();
  PaintedFrame frame(device, mesh, T);
  frame.shape.start_frame();
  const ContourTerms at = frame.contour.linearize(T, 0, kClosestSearch);
  REQUIRE(at.found);
  CHECK(at.score() > 0.8);
  CHECK(std::sqrt(at.sums.weighted_square / at.sums.weight) < 0.3);
  const Matrix6 B = to_camera_axes(T);
  for (int axis = 0; axis < 6; ++axis) {
    CAPTURE(axis);
    // The contour is moved off its edge both ways by some tenths of a pixel.
    const double size = 0.2 / std::sqrt((B.transpose() * at.sums.A * B)(axis, axis) / at.sums.weight);
    const Twist y = size * Twist::Unit(axis);
    const ContourTerms there = frame.contour.linearize(perturbed(T, y, frame.extent), 0, kClosestSearch),
                       back = frame.contour.linearize(perturbed(T, -y, frame.extent), 0, kClosestSearch);
    const Twist slope = B.transpose() * (back.sums.h - there.sums.h) / (2 * size);
    const Twist expected = B.transpose() * at.sums.A * B.col(axis);
    CHECK((slope - expected).norm() < 0.25 * expected.norm());
  }
}

TEST_CASE("a pose that is off by a pixel or two is led back by the contour's equations") {
  const Mesh mesh = simulation::textured_box();
  const Device device;
  const Pose T = turned_box_pose();
  PaintedFrame frame(device, mesh, T);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 5; ++trial) {
    CAPTURE(trial);
    const Twist off = Twist::NullaryExpr([&] { return 0.01 * normal(random); });
    Pose T_found = perturbed(T, off, frame.extent);
    frame.shape.start_frame();
    for (int i = 0; i < 12; ++i) {
      const ContourTerms terms = frame.contour.linearize(T_found, 0, i < 4 ? kCloseSearch : kClosestSearch);
      REQUIRE(terms.found);
      T_found = perturbed(T_found, terms.equations.A.ldlt().solve(terms.equations.h), frame.extent);
    }
    const double before = corner_motion(frame.extent, kCamera, T, perturbed(T, off, frame.extent)),
                 after = corner_motion(frame.extent, kCamera, T, T_found);
    CHECK(after < 0.5 * before);
    CHECK(after < 1);
  }
}

TEST_CASE("edges that are all found a little too far out move an object less than if each erred for itself") {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (const double shift : {0.1, 0.3, -0.2}) {
    CAPTURE(shift);
    const ContourSums sums = disc_sums([&](double) { return shift + 0.1 * normal(random); }, 1);
    CHECK(std::abs(step_beside_prior(sums)(2)) < 0.7 * std::abs(step_beside_prior(without_common_shift(sums))(2)));
  }
}

TEST_CASE("edges that lie to one side are followed, common shift or not") {
  const Twist truth = (Twist() << 0.01, -0.02, 0, 0, 0, 0).finished();
  const auto off = [&](double angle) { return 60 * (truth(0) * std::cos(angle) + truth(1) * std::sin(angle)); };
  const ContourSums sums = disc_sums(off, 1);
  CHECK((step_of(sums) - truth).norm() < 0.02 * truth.norm());
}

TEST_CASE("edges that scatter tell less, more lines more, no line nothing") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto information = [&](double deviation, int lines) {
    const ContourSums sums = disc_sums([&](double) { return deviation * normal(random); }, 1, lines);
    return contour_equations(sums, Pose::Identity()).A(0, 0);
  };
  CHECK(information(0.5, 200) < 0.5 * information(0.2, 200));
  CHECK(information(0.3, 200) > 1.5 * information(0.3, 100));
  const NormalEquations none = contour_equations({}, Pose::Identity());
  CHECK(none.A.isZero());
  CHECK(none.h.isZero());
  const NormalEquations some =
      contour_equations(disc_sums([&](double) { return normal(random); }, 1), Pose::Identity());
  CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(some.A).eigenvalues()(0) > -1e-9 * some.A.norm());
}
