#include "solve/carried_spread.hpp"

#include <Eigen/LU>

namespace holdfast {
namespace {

/// How far the object strays from its motion in a frame where nothing shows it, and where that motion is not known:
/// object radii and radians.
constexpr double kDrift = 0.01, kUnknownDrift = 0.05;

}  // namespace

void CarriedSpread::set(const Pose& T_camera_object, const Matrix6& covariance) {
  // Its motion is what it is from the pose before.
  const Matrix6 before = this->covariance();
  covariance_ << covariance, covariance, covariance, covariance + before;
  T_camera_object_ = T_camera_object;
}

void CarriedSpread::carry(const Pose& T_to, bool motion_known) {
  const Eigen::Matrix3d turn = T_to.linear() * T_camera_object_.linear().transpose();
  Matrix12 goes_on = Matrix12::Zero();
  for (int i = 0; i < 12; i += 3) goes_on.block<3, 3>(i, i) = turn;
  if (motion_known) goes_on.topRightCorner<6, 6>() = goes_on.topLeftCorner<6, 6>();
  covariance_ = goes_on * covariance_ * goes_on.transpose();
  const double drift = motion_known ? kDrift : kUnknownDrift;
  covariance_.topLeftCorner<6, 6>() += drift * drift * Matrix6::Identity();
  T_camera_object_ = T_to;
}

void CarriedSpread::add(const Matrix6& information) {
  // (S^-1 + information)^-1 of the pose, without inverting what may be singular.
  const Matrix6 spread = covariance();
  const Matrix6 gain = information * (Matrix6::Identity() + spread * information).inverse();
  covariance_ -= (covariance_.leftCols<6>() * gain * covariance_.topRows<6>()).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

}  // namespace holdfast
