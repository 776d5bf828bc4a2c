#include "carried_spread.hpp"

#include "covariance.hpp"

namespace holdfast {
namespace {

/// How far the object strays from its motion in a frame where nothing shows it, and where that motion is not known:
/// object radii and radians.
constexpr double kDrift = 0.01, kUnknownDrift = 0.05;

}  // namespace

void CarriedSpread::set(const Pose& T_camera_object, const Matrix6& covariance) {
  T_camera_object_ = T_camera_object;
  covariance_ = covariance;
}

void CarriedSpread::carry(const Pose& T_to, bool motion_known) {
  const Eigen::Matrix3d turn = T_to.linear() * T_camera_object_.linear().transpose();
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = turn;
  const double drift = motion_known ? kDrift : kUnknownDrift;
  covariance_ = both * covariance_ * both.transpose() + drift * drift * Matrix6::Identity();
  T_camera_object_ = T_to;
}

void CarriedSpread::add(const Matrix6& information) {
  covariance_ = symmetric_inverse(symmetric_inverse(covariance_) + information);
}

}  // namespace holdfast
