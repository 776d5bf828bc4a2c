// What lines across edges say of a pose: their rows against central differences, and what their equations leave open.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "edges/edge_sums.hpp"
#include "support/edge_shapes.hpp"

namespace {

using namespace holdfast;

const Camera kCamera{640, 480, 610, 590, 318.3, 244.1, {}};

Pose posed(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  return exp_se3((Twist() << translation, rotation).finished());
}

/// A block or can, seen from somewhere, with lines at all of its edges.
struct Scene {
  Scene(const Mesh& mesh, const Pose& pose, const Camera& its_camera = kCamera)
      : T(pose),
        camera(its_camera),
        extent{mesh.center().cast<double>(), mesh.radius()},
        samples(model_edges(mesh, 240)),
        lines(test::lines_at(samples, T, camera)) {}

  /// Of lines that find their edges `offset(i)` pixels along their normals.
  EdgeSums sums(const std::function<double(std::size_t)>& offset, const Pose& D = Pose::Identity()) const {
    EdgeSums result({T * extent.p_object_center, extent.radius});
    for (std::size_t i = 0; i < lines.size(); ++i) result.add(lines[i], D, camera, samples[i].chain, 0.8, offset(i));
    return result;
  }

  /// How far the edge lies along the line's normal at another pose, from where it is with the lines moved by D.
  double offset(std::size_t i, const Pose& T_other, const Pose& D = Pose::Identity()) const {
    const Eigen::Vector3d p_object = samples[i].p_object.cast<double>();
    return lines[i].normal.dot(camera.project(T_other * p_object) - camera.project(D * lines[i].p_camera));
  }

  Pose T;
  Camera camera;
  Extent extent;
  std::vector<EdgeSample> samples;
  std::vector<VisibleEdge> lines;
};

Scene block_scene() { return {test::block({0.16F, 0.1F, 0.06F}), posed({0.03, -0.02, 0.6}, {0.5, 0.6, 0.2})}; }

Twist solution(const NormalEquations& equations) { return equations.A.ldlt().solve(equations.h); }

}  // namespace

TEST_CASE("a row is how far a point goes along the line's direction with the perturbation: central differences") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Eigen::Vector3d(uniform(random), uniform(random), uniform(random)); };
  for (int trial = 0; trial < 20; ++trial) {
    CAPTURE(trial);
    const Conditioning conditioning{Eigen::Vector3d(0, 0, 0.6) + 0.1 * vector(), 0.08};
    const Eigen::Vector3d p = conditioning.p_camera_center + 0.08 * vector();
    const Pose D = posed(0.02 * vector(), 0.3 * vector());
    const Eigen::Vector2d direction = vector().head<2>();
    const Twist row = EdgeSums::row(p, D, direction, kCamera, conditioning);
    for (int axis = 0; axis < 6; ++axis) {
      constexpr double kStep = 1e-5;
      const auto along = [&](double size) {
        Eigen::Vector3d moved = p;
        if (axis < 3) {
          moved += conditioning.radius * size * Eigen::Vector3d::Unit(axis);
        } else {
          moved = conditioning.p_camera_center +
                  Eigen::AngleAxisd(size, Eigen::Vector3d::Unit(axis - 3)) * (p - conditioning.p_camera_center);
        }
        return direction.dot(kCamera.project(D * moved));
      };
      CHECK(std::abs((along(kStep) - along(-kStep)) / (2 * kStep) - row(axis)) < 1e-5 * row.norm());
    }
  }
}

TEST_CASE("edges that are found where the object has moved to tell how it moved, wherever the lines were laid") {
  const Scene scene = block_scene();
  const Twist y = (Twist() << 0.01, -0.008, 0.012, 0.006, 0.01, -0.008).finished();
  for (const Pose& D : {Pose::Identity(), posed({0.001, -0.002, 0.003}, {0.004, 0.01, -0.01})}) {
    const Pose T_true = perturbed(D * scene.T, y, scene.extent);
    const EdgeSums sums = scene.sums([&](std::size_t i) { return scene.offset(i, T_true, D); }, D);
    CHECK((solution(sums.equations(scene.T)) - y).norm() < 0.05 * y.norm());
  }
}

TEST_CASE("equations are the same however the camera is turned about its axis") {
  const Scene upright{
      test::block({0.16F, 0.1F, 0.06F}), posed({0.03, -0.02, 0.6}, {0.5, 0.6, 0.2}), {640, 480, 600, 600, 0, 0, {}}};
  Pose T_turned = upright.T;
  T_turned = posed({0, 0, 0}, {0, 0, 0.65}) * T_turned;
  const Scene turned{test::block({0.16F, 0.1F, 0.06F}), T_turned, upright.camera};
  const auto offset = [](std::size_t i) { return std::sin(0.37 * static_cast<double>(i)); };
  const NormalEquations a = upright.sums(offset).equations(upright.T), b = turned.sums(offset).equations(turned.T);
  CHECK((a.A - b.A).norm() < 1e-6 * a.A.norm());
  CHECK((a.h - b.h).norm() < 1e-6 * a.h.norm());
}

TEST_CASE("what all edges of a chain are off by together hardly moves the object") {
  const Scene scene = block_scene();
  const auto noise = [](std::size_t i) { return 0.3 * std::sin(12.9 * static_cast<double>(i)); };
  const Twist before = solution(scene.sums(noise).equations(scene.T));
  for (int chain = 0; chain <= scene.samples.back().chain; ++chain) {
    CAPTURE(chain);
    constexpr double kShift = 1;
    const auto shifted = [&](std::size_t i) { return noise(i) + (scene.samples[i].chain == chain ? kShift : 0); };
    const Twist after = solution(scene.sums(shifted).equations(scene.T));
    const auto moved = [&](const Twist& y) {
      return corner_motion(scene.extent, scene.camera, scene.T, perturbed(scene.T, y, scene.extent));
    };
    const double with = std::abs(moved(after) - moved(before));
    CHECK((after - before).norm() > 0);
    // A chain's lines that err each for themselves, one half of them by twice as much, are believed.
    const auto half = [&](std::size_t i) {
      return noise(i) + (scene.samples[i].chain == chain && scene.samples[i].p_object.sum() > 0 ? 2 * kShift : 0);
    };
    const double apart = moved(solution(scene.sums(half).equations(scene.T)));
    CHECK(with < 0.25 * kShift);
    CHECK(with < apart);
  }
}

TEST_CASE("lines that scatter tell less, as the inverse of their variance; more lines more; no line nothing") {
  const Scene scene = block_scene();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> noise(scene.lines.size());
  for (double& value : noise) value = normal(random);
  const auto sums = [&](double deviation) { return scene.sums([&](std::size_t i) { return deviation * noise[i]; }); };
  CHECK(std::sqrt(sums(0.7).variance()) == doctest::Approx(0.7).epsilon(0.15));
  const double information = sums(0.5).equations(scene.T).A.trace();
  CHECK(sums(1).equations(scene.T).A.trace() == doctest::Approx(0.25 * information).epsilon(0.01));
  // Pixels and blur leave something open even where all lines agree.
  CHECK(sums(0).equations(scene.T).A.trace() == doctest::Approx(sums(0.05).equations(scene.T).A.trace()).epsilon(0.01));
  CHECK(sums(0).equations(scene.T).A.allFinite());

  EdgeSums twice({scene.T * scene.extent.p_object_center, scene.extent.radius});
  for (std::size_t i = 0; i < scene.lines.size(); ++i) {
    for (int n = 0; n < 2; ++n)
      twice.add(scene.lines[i], Pose::Identity(), scene.camera, scene.samples[i].chain, 0.8, 0.5 * noise[i]);
  }
  // Nearly twice as much: what all edges of a chain are off by is the same.
  CHECK(twice.equations(scene.T).A.trace() > 1.7 * information);
  CHECK(twice.equations(scene.T).A.trace() < 2 * information);
  const Matrix6 A = sums(0.5).equations(scene.T).A;
  CHECK(A.isApprox(A.transpose()));
  CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(A).eigenvalues()(0) > 0);

  const EdgeSums none({scene.T * scene.extent.p_object_center, scene.extent.radius});
  CHECK(none.equations(scene.T).A.isZero());
  CHECK(none.equations(scene.T).h.isZero());
  CHECK(none.variance() == 0);
}

TEST_CASE("rims of a can do not tell its turn, though their facets seem to") {
  const Scene can{test::can(0.04F, 0.12F, 48), posed({0.01, 0.02, 0.5}, {1.2, 0.2, 0.1})};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto noise = [&](std::size_t) { return 0.4 * normal(random); };
  const NormalEquations equations = can.sums(noise).equations(can.T);
  const Twist turn = Twist::Unit(5);  // about the can's axis
  CHECK(turn.dot(equations.A * turn) < 1e-6 * equations.A.trace());
  CHECK(std::abs(turn.dot(equations.h)) < 1e-3 * equations.h.norm());
  // All other motions show.
  for (int axis = 0; axis < 5; ++axis) {
    CAPTURE(axis);
    CHECK(equations.A(axis, axis) > 1e-4 * equations.A.trace());
  }
  const Scene block = block_scene();
  const NormalEquations all = block.sums(noise).equations(block.T);
  CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(all.A).eigenvalues()(0) > 1e-4 * all.A.trace());
}
