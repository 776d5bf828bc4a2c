#include "covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Errors that no tile's scores show because the solution absorbs them: a displacement of each tile's image, pixels of
/// the level, standard deviation. Texture sampling, tessellation and calibration are of this kind. Calibrated on
/// simulated sequences.
constexpr double kTileDisplacement = 0.025;
/// Neighbouring tiles are not quite independent. Calibrated likewise.
constexpr double kTileCorrelation = 1.5;

}  // namespace

Matrix6 score_covariance(const FlowConstraints& constraints, const Twist& conditioned_step,
                         const Conditioning& conditioning, double fx, double fy) {
  const std::vector<float>& sums = constraints.tile_sums();
  const kernel::hf_rect& tiles = constraints.tiles();
  const auto count = static_cast<std::size_t>(tiles.width) * static_cast<std::size_t>(tiles.height);
  const double z = conditioning.p_camera_center.z();
  // A tile's A in its first two unknowns is its gradients' squares times this.
  const double per_pixel2 = z * z / (conditioning.radius * conditioning.radius * (fx * fx + fy * fy));
  Matrix6 S = Matrix6::Zero();
  int informative = 0;
  for (std::size_t tile = 0; tile < count; ++tile) {
    const float* partial = sums.data() + tile * HF_SUM_STRIDE;
    if (partial[HF_SUM_ROWS] <= 0.0f) continue;
    ++informative;
    Matrix6 A;
    Twist h;
    std::size_t n = HF_SUM_A;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) A(i, j) = A(j, i) = static_cast<double>(partial[n++]);
      h(i) = static_cast<double>(partial[HF_SUM_H + i]);
    }
    const Twist score = h - A * conditioned_step;
    const double displacement = kTileDisplacement * kTileDisplacement * per_pixel2 * (A(0, 0) + A(1, 1));
    S += kTileCorrelation * score * score.transpose() + displacement * A;
  }
  // Few tiles fit their own solution too well, as few points do a line.
  const double few = informative > 9 ? informative / (informative - 6.0) : 3.0;
  return few * S;
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

}  // namespace holdfast
