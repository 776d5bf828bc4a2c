#pragma once

#include "flow_constraints.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Covariance of the last pose, conditioned, carried on from frame to frame while nothing shows all of the pose anew
/// (equation 33 of docs/math.md).
class CarriedSpread {
 public:
  void clear() { *this = {}; }
  /// Whether anything has told of a pose yet.
  bool known() const { return covariance_.trace() > 0; }
  const Matrix6& covariance() const { return covariance_; }
  /// A pose that was measured.
  void set(const Pose& T_camera_object, const Matrix6& covariance);
  /// To where the object has come to a frame later.
  void carry(const Pose& T_to, bool motion_known);
  /// What a measurement of its own says of that pose.
  void add(const Matrix6& information);

 private:
  Matrix6 covariance_ = Matrix6::Zero();
  Pose T_camera_object_ = Pose::Identity();
};

}  // namespace holdfast
