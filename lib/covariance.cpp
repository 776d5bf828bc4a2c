#include "covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace holdfast {
namespace {

/// What blocks of tiles do not show of what tiles have in common, and what a row's residual tells beside its tile's
/// score: rows that are worth one observation, as a root. Both calibrated on simulated objects (`make robustness`,
/// covariance-made-for).
constexpr double kBlockCorrelation = 1.5, kRowCorrelation = 1.4;
/// Few blocks fit their own solution too well, as few points do a line; a tile has a share in several blocks.
constexpr double kTilesPerBlock = 2.25, kFewestBlocks = 9, kFewInflation = 3;

/// The normal equations of a tile: A to the upper triangle's order, and what is left of h after the step.
struct TileEquations {
  Matrix6 A;
  Twist score;

  TileEquations(const float* sums, const Twist& step) {
    std::size_t n = HF_SUM_A;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) A(i, j) = A(j, i) = static_cast<double>(sums[n++]);
      score(i) = static_cast<double>(sums[HF_SUM_H + i]);
    }
    score -= A * step;
  }
};

}  // namespace

Matrix6 score_covariance(std::span<const float> tile_sums, const kernel::hf_rect& tiles,
                         const Twist& conditioned_step) {
  const auto sums_of = [&](int column, int row) -> const float* {
    if (column < 0 || row < 0 || column >= tiles.width || row >= tiles.height) return nullptr;
    const float* sums = tile_sums.data() + static_cast<std::size_t>(row * tiles.width + column) * HF_SUM_STRIDE;
    return sums[HF_SUM_ROWS] > 0.0f ? sums : nullptr;
  };
  Matrix6 blocks = Matrix6::Zero(), rows = Matrix6::Zero();
  int informative = 0;
  // Every 2x2 block of tiles, one overlapping the next: what neighbours have in common adds up in it.
  for (int row = 0; row <= tiles.height; ++row) {
    for (int column = 0; column <= tiles.width; ++column) {
      Twist block = Twist::Zero();
      for (const auto& [left, up] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const float* sums = sums_of(column - left, row - up);
        if (sums == nullptr) continue;
        const TileEquations tile(sums, conditioned_step);
        block += tile.score;
        if (left == 0 && up == 0) {
          ++informative;
          rows += static_cast<double>(sums[HF_SUM_WRR]) / std::max(1e-9, static_cast<double>(sums[HF_SUM_W])) * tile.A;
        }
      }
      blocks += 0.25 * block * block.transpose();
    }
  }
  const double count = informative / kTilesPerBlock;
  const double few = count > kFewestBlocks ? count / (count - 6.0) : kFewInflation;
  return few * kBlockCorrelation * blocks + kRowCorrelation * kRowCorrelation * rows;
}

Matrix6 pose_covariance(const Matrix6& A, const Matrix6& S, double prior_weight, double prior_deviation) {
  const Matrix6 with_prior = A + prior_weight * Matrix6::Identity();
  const Matrix6 scores = S + prior_weight * prior_weight * prior_deviation * prior_deviation * Matrix6::Identity();
  const Eigen::LDLT<Matrix6> factors(with_prior);
  const Matrix6 half = factors.solve(scores);
  const Matrix6 covariance = factors.solve(half.transpose());
  return 0.5 * (covariance + covariance.transpose());
}

double posterior_deviation(const Matrix6& A, double prior_weight, double prior_deviation) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(A, Eigen::EigenvaluesOnly);
  return prior_deviation * std::sqrt(prior_weight / (prior_weight + std::max(0.0, solver.eigenvalues()(0))));
}

void Restlessness::clear() {
  smooth_ = sudden_ = kExpected * kExpected * Matrix6::Identity();
  weight_ = 1;
  followed_ = false;
}

void Restlessness::add(const Twist& conditioned_deviation) {
  const Twist change = conditioned_deviation - last_;
  last_ = conditioned_deviation;
  if (std::exchange(followed_, true)) {
    weight_ = std::min(weight_ + 1, kMemory);
    smooth_ += (conditioned_deviation * conditioned_deviation.transpose() - smooth_) / weight_;
    // A sudden change of velocity shows twice: when it comes, and when it does not come again.
    sudden_ += (0.5 * change * change.transpose() - sudden_) / weight_;
  }
}

Matrix6 Restlessness::within(double exposure) const {
  const double at_once = exposure / 8, gradually = exposure * exposure / 24;
  return at_once * at_once * sudden_ + gradually * gradually * smooth_;
}

}  // namespace holdfast
