#include "evaluation/pose_error.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace holdfast::evaluation {

double PoseError::depth() const { return std::abs(translation.z()); }

PoseError pose_error(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated) {
  PoseError error;
  if (!T_camera_object_estimated.matrix().allFinite()) {
    error.translation.setConstant(std::numeric_limits<double>::infinity());
    error.rotation = std::numeric_limits<double>::infinity();
    return error;
  }
  error.translation = T_camera_object_estimated.translation() - T_camera_object_true.translation();
  error.rotation = rotation_angle(T_camera_object_true.linear() * T_camera_object_estimated.linear().transpose());
  return error;
}

bool Tolerance::holds(const PoseError& error) const {
  return error.distance() <= translation && error.rotation <= rotation;
}

Tolerance tolerance_mm_deg(double millimetres, double degrees) { return {millimetres * 1e-3, to_radians(degrees)}; }

double normalized_error_squared(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated,
                                const Matrix6& information) {
  if (!T_camera_object_estimated.matrix().allFinite() || !information.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  const Twist error = log_se3(T_camera_object_estimated.inverse() * T_camera_object_true);
  return error.dot(information * error);
}

double to_degrees(double radians) { return radians * 180.0 / std::numbers::pi; }
double to_radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace holdfast::evaluation
