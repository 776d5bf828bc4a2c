#include "holdfast/pose.hpp"

#include <Eigen/SVD>
#include <cmath>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& w) {
  Eigen::Matrix3d matrix;
  matrix << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return matrix;
}

// Below this squared angle the closed forms lose digits to cancellation and five series terms are exact to rounding.
constexpr double kSmallSquaredAngle = 0.04;

// sin(t) / t
double sinc(double squared_angle) {
  if (squared_angle < kSmallSquaredAngle) {
    const double s = squared_angle;
    return 1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110))));
  }
  const double angle = std::sqrt(squared_angle);
  return std::sin(angle) / angle;
}

// (t - sin t) / t^3
double sine_remainder(double squared_angle) {
  if (squared_angle < kSmallSquaredAngle) {
    const double s = squared_angle;
    return (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110)))) / 6;
  }
  return (1 - sinc(squared_angle)) / squared_angle;
}

// (1 - (t/2) cot(t/2)) / t^2: finite up to pi, where the usual form divides by sin(t).
double inverse_coefficient(double squared_angle) {
  if (squared_angle < kSmallSquaredAngle) {
    const double s = squared_angle;
    return 1.0 / 12 + s * (1.0 / 720 + s * (1.0 / 30240 + s * (1.0 / 1209600 + s / 47900160)));
  }
  const double half = std::sqrt(squared_angle) / 2;
  return (1 - half * std::cos(half) / std::sin(half)) / squared_angle;
}

}  // namespace

Pose exp_se3(const Twist& twist) {
  const Eigen::Vector3d v = twist.head<3>();
  const Eigen::Vector3d w = twist.tail<3>();
  const double squared_angle = w.squaredNorm();
  const double half_sinc = sinc(squared_angle / 4);
  const double b = half_sinc * half_sinc / 2;  // (1 - cos t) / t^2 without its cancellation
  const Eigen::Matrix3d W = skew(w);
  const Eigen::Matrix3d W2 = W * W;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Matrix3d::Identity() + sinc(squared_angle) * W + b * W2;
  pose.translation() = v + b * (W * v) + sine_remainder(squared_angle) * (W2 * v);
  return pose;
}

Twist log_se3(const Pose& pose) {
  // The quaternion is well conditioned at every angle, at pi too, where R - R^T vanishes.
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0) {
    q.coeffs() = -q.coeffs();
  }
  const double sine = q.vec().stableNorm();
  const double factor = sine > 0 ? 2 * std::atan2(sine, q.w()) / sine : 2.0;
  const Eigen::Vector3d w = factor * q.vec();
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Vector3d w_cross_t = w.cross(t);
  Twist twist;
  twist.head<3>() = t - w_cross_t / 2 + inverse_coefficient(w.squaredNorm()) * w.cross(w_cross_t);
  twist.tail<3>() = w;
  return twist;
}

Pose renormalized(const Pose& pose) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(pose.linear(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  const Eigen::Matrix3d V = svd.matrixV();
  if ((U * V.transpose()).determinant() < 0) {
    U.col(2) = -U.col(2);  // the axis of the smallest singular value: the nearest rotation, not a reflection
  }
  Pose result = Pose::Identity();
  result.linear() = U * V.transpose();
  result.translation() = pose.translation();
  return result;
}

double rotation_angle(const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d twice_sine_axis(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                                        rotation(1, 0) - rotation(0, 1));
  return std::atan2(twice_sine_axis.norm(), rotation.trace() - 1);
}

void validate_pose(const Pose& pose, double tolerance) {
  if (!pose.matrix().allFinite()) {
    throw Error(ErrorCode::pose, "pose: the matrix holds NaN or infinity; give a finite rotation and translation");
  }
  if (pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw Error(ErrorCode::pose, "pose: the matrix's last row is not 0 0 0 1; give a rigid motion [R t; 0 0 0 1]");
  }
  const Eigen::Matrix3d R = pose.linear();
  const double deviation = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (deviation > tolerance) {
    throw Error(ErrorCode::pose, "pose: the 3x3 part is not a rotation (R^T R differs from the identity by " +
                                     std::to_string(deviation) +
                                     "); give orthonormal axes without scale, or renormalise the pose");
  }
  if (R.determinant() < 0) {
    throw Error(ErrorCode::pose,
                "pose: the 3x3 part is a reflection (determinant -1); check the signs and the order of the axes");
  }
}

}  // namespace holdfast
