// The covariance of a pose against errors that are drawn: tiles whose rows have independent noise, and tiles that share
// theirs with their neighbours.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "motion/restlessness.hpp"
#include "solve/covariance.hpp"
#include "texture/score_covariance.hpp"

namespace {

using namespace holdfast;

constexpr int kColumns = 14, kRows = 11, kRowsATile = 60;
constexpr double kChiSquared6At95 = 12.592;

Matrix6 block_covariance(std::span<const TileEquations> tiles, int columns, const Twist& conditioned_step,
                         const Matrix6& A) {
  std::vector<TileEquations> strip;
  return score_covariance(tiles, columns, conditioned_step, A, strip);
}

struct Trial {
  std::vector<float> sums;
  Matrix6 A = Matrix6::Zero();
  Twist h = Twist::Zero();
};

/// Tiles of random rows whose residuals are noise; `shared` of its variance is one displacement along the tile's
/// gradient that a tile has in common with the tiles to its right, below, and between, and `reach` x `reach` tiles
/// among each other.
Trial random_trial(std::mt19937& random, double shared, int reach = 1) {
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
        return common[static_cast<std::size_t>((y / reach + j) * (kColumns + 1) + x / reach + i)];
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

std::vector<TileEquations> equations_of(const Trial& trial) {
  std::vector<TileEquations> equations;
  tile_equations(trial.sums, {0, 0, kColumns, kRows}, equations);
  return equations;
}

/// Share of solutions whose error (the truth is nought) is inside the 95 % ellipsoid, and the same for a covariance
/// that takes rows to be independent.
struct Covered {
  double reported = 0, independent = 0;
  double mean_square = 0;  ///< of the errors by the reported covariance: 6 where it is exact
};

/// `make(random)` draws a Trial.
template <typename Make>
Covered covered(Make make) {
  std::mt19937 random(7);
  Covered out;
  constexpr int trials = 400;
  for (int i = 0; i < trials; ++i) {
    const Trial trial = make(random);
    const Twist y = trial.A.ldlt().solve(trial.h);
    const Matrix6 S = block_covariance(equations_of(trial), kColumns, y, trial.A);
    const Matrix6 inverse = symmetric_inverse(trial.A), covariance = inverse * S * inverse;
    const double square = y.dot(covariance.ldlt().solve(y));
    out.reported += square <= kChiSquared6At95;
    out.mean_square += square;
    out.independent += y.dot(trial.A * y) <= kChiSquared6At95;
  }
  return {out.reported / trials, out.independent / trials, out.mean_square / trials};
}

}  // namespace

TEST_CASE("covariance: rows with noise of their own are covered") {
  const Covered share = covered([](std::mt19937& random) { return random_trial(random, 0); });
  CHECK(share.independent > 0.92);
  CHECK(share.reported > 0.88);
  CHECK(share.mean_square == doctest::Approx(6).epsilon(0.25));
}

// It is shared along one direction; of few blocks some of it is taken to be along all: deviations up to 1.5 times as
// large.
TEST_CASE("covariance: noise that a tile's rows and its neighbours share is covered too") {
  const Covered share = covered([](std::mt19937& random) { return random_trial(random, 0.5); });
  CHECK(share.independent < 0.5);
  CHECK(share.reported > 0.88);
  CHECK(share.mean_square > 6 / (1.5 * 1.5));
  CHECK(share.mean_square < 6 * 1.25);
}

// Errors of texture and light that a large object's faces share, far beyond a tile's neighbours.
TEST_CASE("covariance: noise that large parts of a large object share is nearly covered") {
  const Covered share = covered([](std::mt19937& random) { return random_trial(random, 0.5, 3); });
  CHECK(share.independent < 0.3);
  CHECK(share.reported > 0.85);
  CHECK(share.mean_square == doctest::Approx(6).epsilon(0.25));
}

// A dozen tiles fit the solution that they decide: what they leave over says little.
TEST_CASE("covariance: a few tiles that decide alone are not taken for as many as there are") {
  const auto few = [](std::mt19937& random) {
    Trial trial = random_trial(random, 0.5);
    trial.A.setZero();
    trial.h.setZero();
    for (int tile = 0; tile < kColumns * kRows; ++tile) {
      const double scale = tile % 13 == 0 ? 1 : 1e-3;
      float* sums = trial.sums.data() + static_cast<std::size_t>(tile) * HF_SUM_STRIDE;
      for (int i = 0; i < HF_SUM_WRR; ++i) sums[i] *= static_cast<float>(scale);
      const TileEquations equations = equations_of(trial)[static_cast<std::size_t>(tile)];
      trial.A += equations.A;
      trial.h += equations.h;
    }
    return trial;
  };
  const Covered share = covered(few);
  CHECK(share.independent < 0.5);
  CHECK(share.reported > 0.88);
  CHECK(share.mean_square == doctest::Approx(6).epsilon(0.25));
}

TEST_CASE("covariance: an error that all edges share in their own senses is allowed for, whatever they leave over") {
  std::mt19937 random(5);
  const Trial trial = random_trial(random, 0);
  std::vector<TileEquations> equations = equations_of(trial);
  Twist sum = Twist::Zero();
  const Matrix6 before = block_covariance(equations, kColumns, Twist::Zero(), trial.A);
  std::normal_distribution<double> normal;
  for (TileEquations& tile : equations) {
    for (int i = 0; i < 6; ++i) tile.to_dark(i) = normal(random);
    sum += tile.to_dark;
  }
  const Matrix6 more = block_covariance(equations, kColumns, Twist::Zero(), trial.A) - before;
  CHECK((more - 0.01 * sum * sum.transpose()).norm() < 1e-9 * before.norm());
}

TEST_CASE("covariance: a view drawn a little to the side moves the pose sideways, whatever its distance") {
  Conditioning conditioning;
  conditioning.radius = 0.2;
  conditioning.p_camera_center = {0.3, -0.1, 0.9};
  const Matrix6 C = drawing_covariance(conditioning, 640);
  const Eigen::Vector3d ray = conditioning.p_camera_center.normalized();
  CHECK(C.bottomRows<3>().norm() == 0);
  CHECK((C.topLeftCorner<3, 3>() * ray).norm() < 1e-12);
  // Of the object's centre, projected at right angles to its ray: a 512th of a pixel, both ways.
  const Eigen::Vector3d side = ray.cross(Eigen::Vector3d::UnitY()).normalized();
  const double metres = conditioning.radius * std::sqrt(side.dot(C.topLeftCorner<3, 3>() * side));
  CHECK(640 * metres / conditioning.p_camera_center.norm() == doctest::Approx(1.0 / 512));
  conditioning.p_camera_center *= 3;
  CHECK((drawing_covariance(conditioning, 640) - 9 * C).norm() < 1e-12 * C.norm() + 1e-18);
}

// One unknown number from many rows with Student's noise, as the tracker solves for a pose.
TEST_CASE("covariance: Student's weights fall with the residual, so the scores change less than the weights say") {
  constexpr double kFreedom = 4;
  std::mt19937 random(11);
  std::student_t_distribution<double> noise(kFreedom);
  std::vector<double> residuals(20000);
  for (double& residual : residuals) residual = noise(random);
  const auto score = [&](double shift, double scale2, double& mean_weight, double& spread) {
    double sum = 0, weights = 0, squares = 0;
    for (const double residual : residuals) {
      const double r = residual - shift, w = (kFreedom + 1) / (kFreedom + r * r / scale2);
      sum += w * r;
      weights += w;
      squares += w * r * r;
    }
    const double count = static_cast<double>(residuals.size());
    mean_weight = weights / count;
    spread = squares / count;
    return sum / count;
  };
  for (const double too_large : {1.0, 2.0, 4.0}) {
    CAPTURE(too_large);
    double scale2 = 1, weight = 1, spread = 1;
    for (int i = 0; i < 50; ++i, scale2 = spread) score(0, scale2, weight, spread);
    scale2 *= too_large * too_large;
    double other_weight = 0;
    const double slope = (score(-0.01, scale2, other_weight, spread) - score(0.01, scale2, weight, spread)) / 0.02;
    score(0, scale2, weight, spread);
    CHECK(slope / weight == doctest::Approx(robust_curvature(weight, kFreedom)).epsilon(0.03));
  }
  CHECK(robust_curvature(1, kFreedom) == doctest::Approx(5.0 / 7));
  CHECK(robust_curvature(1.25, kFreedom) == 1);
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
  std::vector<TileEquations> equations;
  tile_equations(padded, {0, 0, kColumns + 1, kRows + 1}, equations);
  const Matrix6 S = block_covariance(equations_of(trial), kColumns, y, trial.A);
  const Matrix6 same = block_covariance(equations, kColumns + 1, y, trial.A);
  CHECK((S - same).norm() < 1e-9 * S.norm());
  // Nor does what an earlier, larger region left behind them.
  std::vector<float> longer = trial.sums;
  longer.insert(longer.end(), trial.sums.begin(), trial.sums.begin() + 5 * kColumns * HF_SUM_STRIDE);
  tile_equations(longer, {0, 0, kColumns, kRows}, equations);
  CHECK(block_covariance(equations, kColumns, y, trial.A) == S);
  tile_equations(std::vector<float>(HF_SUM_STRIDE, 0.0f), {0, 0, 1, 1}, equations);
  CHECK(block_covariance(equations, 1, y, trial.A).norm() == 0);
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
