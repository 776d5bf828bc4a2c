#pragma once

#include "holdfast/pose.hpp"

namespace holdfast {

/// The change of variables that kernels sum up with: translation in units of `radius`, rotation about
/// `p_camera_center`, camera axes (equation 11 of docs/math.md).
struct Conditioning {
  Eigen::Vector3d p_camera_center = Eigen::Vector3d::Zero();
  double radius = 1;

  /// Twist about the camera's origin of a conditioned one.
  Twist twist(const Twist& conditioned) const;
  /// The inverse of twist().
  Twist conditioned(const Twist& twist) const;
};

}  // namespace holdfast
