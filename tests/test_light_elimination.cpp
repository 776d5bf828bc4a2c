// What elimination of light leaves of a pose's constraints, where it would take more than there is.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <random>

#include "texture/photometry.hpp"

namespace {

using namespace holdfast;

Matrix6 random_matrix(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Matrix6::NullaryExpr([&] { return normal(random); });
}

/// A motion of length 1.
Twist random_motion(std::mt19937& random) { return random_matrix(random).col(0).normalized(); }

}  // namespace

TEST_CASE("where light leaves something of every motion, nothing is taken") {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix6 rows = random_matrix(random), left = random_matrix(random);
    const Matrix6 A = left * left.transpose() + 1e-6 * Matrix6::Identity();
    CHECK(left_beside_light(A, A + rows * rows.transpose()) == Matrix6::Identity());
  }
}

TEST_CASE("motions of which light would take more than there is are taken out, and the others stay as they are") {
  std::mt19937 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    // Independent motions, at skew angles, of different weights.
    const Matrix6 motions = Matrix6::Identity() + 0.2 * random_matrix(random);
    Eigen::Matrix<double, 6, 1> weights, shares;
    const int overdrawn = 1 + trial % 3;
    for (int i = 0; i < 6; ++i) {
      weights(i) = std::pow(10.0, 2.0 * i / 5);
      shares(i) = i < overdrawn ? 1.5 + 20 * i : 0.1 * i;  // that light takes
    }
    // Of each motion alone, by rows: rows = sum of weight a a^T, where a is dual to the motions.
    const Matrix6 dual = motions.inverse().transpose();
    const Matrix6 A_rows = dual * weights.asDiagonal() * dual.transpose();
    const Matrix6 A = dual * (weights.array() * (1 - shares.array())).matrix().asDiagonal() * dual.transpose();
    REQUIRE(Eigen::SelfAdjointEigenSolver<Matrix6>(A).eigenvalues()(0) < 0);

    const Matrix6 P = left_beside_light(A, A_rows), left = P.transpose() * A * P;
    const double scale = A_rows.norm();
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(left).eigenvalues()(0) > -1e-9 * scale);
    CHECK((P * P - P).norm() < 1e-3 * P.norm());
    const Twist h = A * random_motion(random);
    for (int i = 0; i < 6; ++i) {
      CAPTURE(i);
      const Twist y = motions.col(i);
      if (i < overdrawn) {
        CHECK((left * y).norm() < 1e-3 * (A_rows * y).norm());
        CHECK(std::abs(y.dot(P.transpose() * h)) < 1e-3 * y.norm() * h.norm());
      } else {
        CHECK((left * y - A * y).norm() < 1e-3 * (A * y).norm());
        CHECK(y.dot(P.transpose() * h) == doctest::Approx(y.dot(h)).epsilon(1e-3));
      }
    }
  }
}

TEST_CASE("of a single pixel, too") {
  std::mt19937 random(7);
  const Twist row = random_motion(random);
  const Matrix6 A_rows = row * row.transpose(), A = -0.5 * A_rows;
  const Matrix6 P = left_beside_light(A, A_rows);
  CHECK(P.allFinite());
  CHECK((P.transpose() * A * P).norm() < 1e-5);
}
