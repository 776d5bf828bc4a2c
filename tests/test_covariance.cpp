// The covariance of a pose against errors that are drawn: tiles whose rows have independent noise, and tiles that share
// theirs with their neighbours.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "covariance.hpp"

namespace {

using namespace holdfast;

constexpr int kColumns = 14, kRows = 11, kRowsATile = 60;
constexpr double kChiSquared6At95 = 12.592;

struct Trial {
  std::vector<float> sums;
  Matrix6 A = Matrix6::Zero();
  Twist h = Twist::Zero();
};

/// Tiles of random rows whose residuals are noise; `shared` of its variance is one displacement along the tile's
/// gradient that a tile has in common with the tiles to its right, below, and between.
Trial random_trial(std::mt19937& random, double shared) {
  std::normal_distribution<double> normal;
  Trial trial;
  trial.sums.assign(static_cast<std::size_t>(kColumns * kRows) * HF_SUM_STRIDE, 0.0f);
  std::vector<double> common(static_cast<std::size_t>((kColumns + 1) * (kRows + 1)));
  for (double& value : common) value = normal(random);
  // A direction that all tiles see alike, as a translation is seen.
  const Twist direction = (Twist() << 1, 0.3, 0.1, 0.2, 0, 0.1).finished();
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const auto corner = [&](int i, int j) {
        return common[static_cast<std::size_t>((y + j) * (kColumns + 1) + x + i)];
      };
      const double tile_noise = std::sqrt(shared) * 0.5 * (corner(0, 0) + corner(1, 0) + corner(0, 1) + corner(1, 1));
      Matrix6 A = Matrix6::Zero();
      Twist h = Twist::Zero();
      double squares = 0;
      for (int k = 0; k < kRowsATile; ++k) {
        Twist row;
        for (int i = 0; i < 6; ++i) row(i) = normal(random);
        row += direction;
        const double residual = tile_noise + std::sqrt(1 - shared) * normal(random);
        A += row * row.transpose();
        h += row * residual;
        squares += residual * residual;
      }
      float* out = trial.sums.data() + static_cast<std::size_t>(y * kColumns + x) * HF_SUM_STRIDE;
      std::size_t n = HF_SUM_A;
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) out[n++] = static_cast<float>(A(i, j));
        out[HF_SUM_H + i] = static_cast<float>(h(i));
      }
      out[HF_SUM_WRR] = static_cast<float>(squares);
      out[HF_SUM_W] = out[HF_SUM_ROWS] = kRowsATile;
      trial.A += A;
      trial.h += h;
    }
  }
  return trial;
}

/// Share of solutions whose error (the truth is nought) is inside the 95 % ellipsoid, and the same for a covariance
/// that takes rows to be independent.
struct Covered {
  double reported = 0, independent = 0;
  double mean_square = 0;  ///< of the errors by the reported covariance: 6 where it is exact
};

Covered covered(double shared) {
  std::mt19937 random(7);
  Covered out;
  constexpr int trials = 400;
  for (int i = 0; i < trials; ++i) {
    const Trial trial = random_trial(random, shared);
    const Twist y = trial.A.ldlt().solve(trial.h);
    const Matrix6 S = score_covariance(trial.sums, {0, 0, kColumns, kRows}, y);
    const Matrix6 covariance = pose_covariance(trial.A, S, 1e-9, 1);
    const double square = y.dot(covariance.ldlt().solve(y));
    out.reported += square <= kChiSquared6At95;
    out.mean_square += square;
    out.independent += y.dot(trial.A * y) <= kChiSquared6At95;
  }
  return {out.reported / trials, out.independent / trials, out.mean_square / trials};
}

}  // namespace

// What the constants allow for beyond what is drawn here (errors of texture, light and lens) makes the standard
// deviations up to twice as large.
TEST_CASE("covariance: rows with noise of their own are covered, and by no more than twice their size") {
  const Covered share = covered(0);
  CHECK(share.independent > 0.92);
  CHECK(share.reported > 0.95);
  CHECK(share.mean_square > 6 / 4.0);
}

TEST_CASE("covariance: noise that a tile's rows and its neighbours share is covered too") {
  const Covered share = covered(0.5);
  CHECK(share.independent < 0.5);
  CHECK(share.reported > 0.95);
  CHECK(share.mean_square > 6 / 4.0);
}

TEST_CASE("covariance: tiles without rows and a region of few tiles") {
  std::mt19937 random(3);
  const Trial trial = random_trial(random, 0);
  const Twist y = trial.A.ldlt().solve(trial.h);
  // An empty column and row of tiles around change nothing.
  std::vector<float> padded(static_cast<std::size_t>((kColumns + 1) * (kRows + 1)) * HF_SUM_STRIDE, 0.0f);
  for (int row = 0; row < kRows; ++row) {
    const auto from = trial.sums.begin() + static_cast<std::ptrdiff_t>(row * kColumns) * HF_SUM_STRIDE;
    std::copy(from, from + kColumns * HF_SUM_STRIDE,
              padded.begin() + static_cast<std::ptrdiff_t>((row + 1) * (kColumns + 1) + 1) * HF_SUM_STRIDE);
  }
  const Matrix6 S = score_covariance(trial.sums, {0, 0, kColumns, kRows}, y);
  const Matrix6 same = score_covariance(padded, {0, 0, kColumns + 1, kRows + 1}, y);
  CHECK((S - same).norm() < 1e-9 * S.norm());
  CHECK(score_covariance(std::vector<float>(HF_SUM_STRIDE, 0.0f), {0, 0, 1, 1}, y).norm() == 0);
}

TEST_CASE("restlessness: sudden changes of velocity weigh by an eighth of the exposure, smooth ones by its square") {
  Twist jump = Twist::Zero();
  jump(0) = 0.4;
  Restlessness sudden, smooth, still;
  for (int i = 0; i < 400; ++i) {
    still.add(Twist::Zero());
    smooth.add(jump);  // the same acceleration all the time
    sudden.add(i % 10 == 0 ? jump : Twist(Twist::Zero()));
  }
  CHECK(still.within(0.5).norm() < 1e-6);
  CHECK(std::sqrt(smooth.within(0.5)(0, 0)) == doctest::Approx(0.4 * 0.25 / 24).epsilon(0.05));
  // One frame in ten: both of the two changes that it makes count half.
  CHECK(std::sqrt(sudden.within(0.5)(0, 0)) == doctest::Approx(0.4 * 0.5 / 8 * std::sqrt(0.1)).epsilon(0.2));
  CHECK(sudden.within(0).norm() == 0);
  CHECK(sudden.within(0.5)(1, 1) < 1e-6);
}
