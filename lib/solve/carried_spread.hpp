#pragma once

#include "holdfast/pose.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// Covariance of the last pose, conditioned, carried on from frame to frame while nothing shows all of the pose anew
/// (equation 33 of docs/math.md). Where the object is taken to go on as it moved, what its last poses were off by goes
/// on too.
class CarriedSpread {
 public:
  void clear() { *this = {}; }
  /// Whether anything has told of a pose yet.
  bool known() const { return covariance_.trace() > 0; }
  Matrix6 covariance() const { return covariance_.topLeftCorner<6, 6>(); }
  /// A pose that was measured, on its own.
  void set(const Pose& T_camera_object, const Matrix6& covariance);
  /// To where the object has come to a frame later.
  void carry(const Pose& T_to, bool motion_known);
  /// What a measurement of its own says of that pose.
  void add(const Matrix6& information);

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  Matrix12 covariance_ = Matrix12::Zero();  ///< of the pose, and of its motion a frame
  Pose T_camera_object_ = Pose::Identity();
};

}  // namespace holdfast
