#pragma once

#include <Eigen/Core>

#include "holdfast/pose.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// The change of variables that the sums are conditioned with: translation in units of `radius`, rotation about
/// `p_camera_center` (equation 11 of docs/math.md).
struct Conditioning {
  Eigen::Vector3d p_camera_center = Eigen::Vector3d::Zero();
  double radius = 1;

  /// Twist about the camera's origin of a conditioned solution.
  Twist twist(const Twist& conditioned) const;
  /// The inverse of twist().
  Twist conditioned(const Twist& twist) const;
  /// Information matrix of the twist of a conditioned one: M^T A M with conditioned = M twist.
  Matrix6 information(const Matrix6& A) const;
};

struct Solution {
  bool solved = false;                ///< false when the constraints leave some motion free
  Twist conditioned = Twist::Zero();  ///< as the sums are
  Twist twist = Twist::Zero();        ///< D <- D exp(twist)
  double smallest_eigenvalue = 0;     ///< of the conditioned A
};

/// Least squares: A y = h, damped by `damping` times A's mean diagonal.
Solution solve(const ConstraintSums& sums, const Conditioning& conditioning, double damping);

}  // namespace holdfast
