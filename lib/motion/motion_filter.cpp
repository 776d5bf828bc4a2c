#include "motion/motion_filter.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "solve/covariance.hpp"

namespace holdfast {
namespace {

/// What velocity changes by in a frame: object radii and radians, standard deviation.
constexpr double kChange = 0.05;
/// Standard deviation of a pose above which nothing has told of a motion for long: object radii and radians.
constexpr double kOpen = 0.2;

}  // namespace

void MotionFilter::predict() {
  covariance_.topRows<6>() += covariance_.bottomRows<6>().eval();
  covariance_.leftCols<6>() += covariance_.rightCols<6>().eval();
  covariance_.bottomRightCorner<6, 6>() += kChange * kChange * Matrix6::Identity();
}

Matrix6 MotionFilter::update(const Matrix6& pose_covariance) {
  const Matrix6 expected = this->pose_covariance();
  const Matrix6 gain = covariance_.bottomLeftCorner<6, 6>() * symmetric_inverse(expected);
  covariance_.bottomRightCorner<6, 6>() -= gain * (expected - pose_covariance) * gain.transpose();
  covariance_.bottomLeftCorner<6, 6>() = gain * pose_covariance;
  covariance_.topRightCorner<6, 6>() = pose_covariance * gain.transpose();
  covariance_.topLeftCorner<6, 6>() = pose_covariance;
  return gain;
}

Matrix6 MotionFilter::rest() {
  const Matrix6 pose = pose_covariance();
  Matrix6 moving = Matrix6::Identity(), shorter = Matrix6::Identity();
  if (pose.trace() <= kOpen * kOpen) return moving;
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(pose);
  if (solver.eigenvalues()(5) <= kOpen * kOpen) return moving;
  for (int i = 5; i >= 0 && solver.eigenvalues()(i) > kOpen * kOpen; --i) {
    const Matrix6 open = solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose();
    moving -= open;
    // Its variance would grow until what is known of the others drowns in its rounding.
    shorter -= (1 - std::min(1.0, kUnknown / std::sqrt(solver.eigenvalues()(i)))) * open;
  }
  covariance_.topLeftCorner<6, 6>() = shorter * pose * shorter;
  covariance_.bottomLeftCorner<6, 6>() = (moving * covariance_.bottomLeftCorner<6, 6>() * shorter).eval();
  covariance_.topRightCorner<6, 6>() = covariance_.bottomLeftCorner<6, 6>().transpose();
  covariance_.bottomRightCorner<6, 6>() = (moving * covariance_.bottomRightCorner<6, 6>() * moving).eval();
  return moving;
}

}  // namespace holdfast
