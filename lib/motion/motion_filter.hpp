#pragma once

#include "texture/flow_constraints.hpp"

namespace holdfast {

/// How surely a followed object's pose and velocity are known together, conditioned: the covariance of a Kalman filter
/// whose velocity changes at random from frame to frame (equations 12b, 12c of docs/math.md). From it comes how surely
/// the next pose is expected, and how much of what the pose is then off by is the velocity's: all of it where poses are
/// sure, little where they mostly follow what was expected of them.
class MotionFilter {
 public:
  /// Nothing is known any more.
  void clear() { *this = {}; }
  /// The object goes on by its velocity for a frame.
  void predict();
  /// Covariance of the pose; after predict(), of the one expected.
  Matrix6 pose_covariance() const { return covariance_.topLeftCorner<6, 6>(); }
  /// The expected pose was looked for, and with what was expected is now known this well. Returns the gain: times what
  /// the pose was off by from there, the change of velocity (a frame) that it tells of.
  Matrix6 update(const Matrix6& pose_covariance);

  /// Motions that nothing has told of for long come to rest: any velocity along them is noise. Returns what is left of
  /// a velocity, conditioned: all of it, the identity, where every motion is known.
  Matrix6 rest();

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  /// Object radii and radians, standard deviation, of pose and velocity that nothing is known of.
  static constexpr double kUnknown = 1;

  Matrix12 covariance_ = kUnknown * kUnknown * Matrix12::Identity();  ///< of the pose, and of its velocity a frame
};

}  // namespace holdfast
