// Perturbations of a pose, and normal equations in them: against their definition, central differences and sums over
// views.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <random>

#include "solve/normal_equations.hpp"
#include "solve/uncertain_origin.hpp"
#include "support/conditioned.hpp"

namespace {

using namespace holdfast;

const Extent kExtent{{0.04, -0.03, 0.07}, 0.15};

Twist random_twist(std::mt19937& random, double size) {
  std::normal_distribution<double> normal;
  return Twist::NullaryExpr([&] { return size * normal(random); });
}

Pose random_pose(std::mt19937& random) {
  Pose pose = exp_se3(random_twist(random, 0.8));
  pose.translation().z() += 1.5;
  return pose;
}

double largest_difference(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("a perturbation leads from one pose to another, and is found again from the two") {
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose T = random_pose(random), T_other = random_pose(random);
    const Twist y = random_twist(random, 0.4);
    CHECK((perturbation_between(T, perturbed(T, y, kExtent), kExtent) - y).norm() < 1e-9);
    CHECK(largest_difference(perturbed(T, perturbation_between(T, T_other, kExtent), kExtent), T_other) < 1e-9);
  }
  const Pose T = random_pose(random);
  CHECK(largest_difference(perturbed(T, Twist::Zero(), kExtent), T) < 1e-12);
}

TEST_CASE("a perturbation moves the centre by radii along the object's axes, and turns about the centre and them") {
  std::mt19937 random(4);
  const Eigen::Vector3d& c = kExtent.p_object_center;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 20; ++i) {
    const Pose T = random_pose(random);
    const Eigen::Vector3d p = random_twist(random, 0.2).head<3>();
    for (int axis = 0; axis < 6; ++axis) {
      const Twist y = kStep * Twist::Unit(axis);
      const Eigen::Vector3d slope = (perturbed(T, y, kExtent) * p - perturbed(T, -y, kExtent) * p) / (2 * kStep);
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis % 3);
      const Eigen::Vector3d expected =
          T.linear() * (axis < 3 ? Eigen::Vector3d(kExtent.radius * unit) : unit.cross(p - c));
      CHECK((slope - expected).norm() < 1e-8);
    }
  }
}

TEST_CASE("the twist of a perturbation moves the pose as it does") {
  std::mt19937 random(5);
  const Matrix6 M = twist_of_perturbation(kExtent);
  constexpr double kStep = 1e-5;
  const Pose T = random_pose(random);
  for (int axis = 0; axis < 6; ++axis) {
    const Twist y = kStep * Twist::Unit(axis);
    const Pose by_twist = T * exp_se3(M * y);
    CHECK(largest_difference(by_twist, perturbed(T, y, kExtent)) < 10 * kStep * kStep);
  }
}

TEST_CASE("a kernel's quadratic in camera axes is the one in object axes") {
  std::mt19937 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose T = random_pose(random);
    const Matrix6 root = Matrix6::NullaryExpr([&] { return random_twist(random, 1)(0); });
    const Matrix6 A = root * root.transpose();
    const Twist h = random_twist(random, 1);
    const NormalEquations equations = NormalEquations::from_camera_axes(A, h, T);
    // What a kernel conditions with: a twist about the camera's origin that moves the drawn view.
    const Conditioning conditioning{T * kExtent.p_object_center, kExtent.radius};
    for (int i = 0; i < 5; ++i) {
      const Twist y = random_twist(random, 1);
      constexpr double kStep = 1e-6;
      const Pose D = perturbed(T, kStep * y, kExtent) * T.inverse();
      const Twist y_camera = test::conditioned(conditioning, log_se3(D)) / kStep;
      CHECK((to_camera_axes(T) * y - y_camera).norm() < 1e-4 * y.norm());
      const double in_camera = 0.5 * y_camera.dot(A * y_camera) - y_camera.dot(h);
      const double in_object = 0.5 * y.dot(equations.A * y) - y.dot(equations.h);
      CHECK(in_object == doctest::Approx(in_camera).epsilon(1e-3).scale(A.norm()));
    }
  }
}

TEST_CASE("equations of two views add up: the sum is solved by the pose that both agree on") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 20; ++trial) {
    // The object moves as one, seen by two cameras; each alone leaves motions open.
    const Twist truth = random_twist(random, 0.01);
    NormalEquations sum;
    for (int view = 0; view < 2; ++view) {
      const Pose T = random_pose(random);
      const Twist truth_camera = to_camera_axes(T) * truth;
      Matrix6 A = Matrix6::Zero();
      Twist h = Twist::Zero();
      for (int row = 0; row < 4; ++row) {
        const Twist j = random_twist(random, 1);
        A += j * j.transpose();
        h += j * j.dot(truth_camera);
      }
      sum += NormalEquations::from_camera_axes(A, h, T);
    }
    CHECK((sum.A.ldlt().solve(sum.h) - truth).norm() < 1e-6 * truth.norm() + 1e-10);
    NormalEquations twice = sum;
    twice *= 2;
    CHECK((twice.A.ldlt().solve(twice.h) - truth).norm() < 1e-6 * truth.norm() + 1e-10);
    CHECK(twice.A == 2 * sum.A);
  }
}

TEST_CASE("equations about an uncertain origin are those of pose and origin together, the origin eliminated") {
  std::mt19937 random(6);
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  using Vector12 = Eigen::Matrix<double, 12, 1>;
  for (int i = 0; i < 20; ++i) {
    const Matrix6 root = Matrix6::NullaryExpr([&] { return random_twist(random, 1)(0); });
    const Matrix6 known_root = Matrix6::NullaryExpr([&] { return random_twist(random, 1)(0); });
    NormalEquations relative;
    relative.A = 50 * root * root.transpose();
    relative.h = relative.A * random_twist(random, 0.01);
    const Matrix6 known = known_root * known_root.transpose() + Matrix6::Identity();
    Twist shift;
    const NormalEquations result = without_origin(relative, known, shift);
    // (y - shift) A (y - shift) and shift K shift are small together, with anything else that is said of y.
    const Matrix6 other = 3 * Matrix6::Identity();
    Matrix12 both = Matrix12::Zero();
    both << relative.A + other, -relative.A, -relative.A, relative.A + known;
    Vector12 right;
    right << relative.h, -relative.h;
    const Vector12 together = both.ldlt().solve(right);
    CHECK((Matrix6(result.A + other).ldlt().solve(result.h) - together.head<6>()).norm() < 1e-9);
    // An origin that is surely known changes nothing, one that is not known leaves nothing.
    CHECK((without_origin(relative, 1e9 * Matrix6::Identity(), shift).A - relative.A).norm() <
          1e-4 * relative.A.norm());
    CHECK(without_origin(relative, 1e-9 * Matrix6::Identity(), shift).A.norm() < 1e-6);
  }
}

TEST_CASE("the farther off an origin is found, the more it pulls, until it is too far to be believed") {
  NormalEquations relative;
  relative.A = 1e6 * Matrix6::Identity();
  const Matrix6 known = 100 * Matrix6::Identity();
  const auto pull = [&](double deviations) {
    Twist shift;
    relative.h = 1e6 * 0.1 * deviations * Twist::Unit(0);
    const NormalEquations result = without_origin(relative, known, shift);
    CHECK(shift(0) == doctest::Approx(-0.1 * deviations).epsilon(0.01));
    return result.h(0);
  };
  CHECK(pull(1) == doctest::Approx(10).epsilon(0.01));
  CHECK(pull(2) == doctest::Approx(20).epsilon(0.01));
  CHECK(pull(6) < 2.5 * 10);
  CHECK(pull(30) < pull(6));
  CHECK(pull(300) < 1);
}
