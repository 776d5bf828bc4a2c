#include "motion_filter.hpp"

#include "covariance.hpp"

namespace holdfast {
namespace {

/// What velocity changes by in a frame: object radii and radians, standard deviation.
constexpr double kChange = 0.05;

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

}  // namespace holdfast
