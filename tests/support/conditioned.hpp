#pragma once

#include "holdfast/pose.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast::test {

/// Twist about the camera's origin of a conditioned one.
inline Twist twist_of(const Conditioning& conditioning, const Twist& conditioned) {
  Twist result;
  const Eigen::Vector3d w = conditioned.tail<3>();
  result << conditioning.radius * conditioned.head<3>() - w.cross(conditioning.p_camera_center), w;
  return result;
}

/// The inverse of twist_of().
inline Twist conditioned(const Conditioning& conditioning, const Twist& twist) {
  Twist result;
  const Eigen::Vector3d w = twist.tail<3>();
  result << (twist.head<3>() + w.cross(conditioning.p_camera_center)) / conditioning.radius, w;
  return result;
}

}  // namespace holdfast::test
