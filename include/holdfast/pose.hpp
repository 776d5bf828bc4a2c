#pragma once

#include <Eigen/Geometry>

#include "holdfast/export.hpp"

namespace holdfast {

/// Rigid motion. As `T_camera_object` it maps points of the object frame to the camera frame, metres.
using Pose = Eigen::Isometry3d;

/// Twist (v, w): translation velocity first (metres), rotation second (radians).
using Twist = Eigen::Matrix<double, 6, 1>;

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Exponential map of SE(3) (equation 3 in docs/math.md).
HOLDFAST_EXPORT Pose exp_se3(const Twist& twist);

/// Logarithm of SE(3), the inverse of exp_se3 for rotations below pi.
HOLDFAST_EXPORT Twist log_se3(const Pose& pose);

/// The nearest rigid motion: repeated products drift off SO(3) and must be renormalised.
HOLDFAST_EXPORT Pose renormalized(const Pose& pose);

/// Angle of the rotation, radians in [0, pi].
HOLDFAST_EXPORT double rotation_angle(const Eigen::Matrix3d& rotation);

/// Throws Error(pose) when the matrix is not finite or not a rotation within `tolerance`.
HOLDFAST_EXPORT void validate_pose(const Pose& pose, double tolerance = 1e-3);

}  // namespace holdfast
