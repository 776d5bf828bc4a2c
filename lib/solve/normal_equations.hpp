#pragma once

#include "base/corner_motion.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Perturbation of a pose in the object's frame about the object's centre, y = (v / radius, w): centre velocity in
/// object radii, rotation in radians, object axes (equation 11 of docs/math.md). In these coordinates the normal
/// equations of every view, camera and modality add up.
Pose perturbed(const Pose& T_camera_object, const Twist& y, const Extent& extent);

/// The y with perturbed(T_from, y) = T_to.
Twist perturbation_between(const Pose& T_from, const Pose& T_to, const Extent& extent);

/// The matrix that turns a perturbation y into the twist xi of T exp(xi): object axes, metres and radians, about the
/// object's origin.
Matrix6 twist_of_perturbation(const Extent& extent);

/// The change of variables that kernels sum up with: translation in units of `radius`, rotation about
/// `p_camera_center`, camera axes (equation 11 of docs/math.md).
struct Conditioning {
  Eigen::Vector3d p_camera_center = Eigen::Vector3d::Zero();
  double radius = 1;
};

/// A y = h: the Gauss-Newton step of one modality, or of several added up. In information units: A is the inverse of a
/// covariance.
struct NormalEquations {
  Matrix6 A = Matrix6::Zero();
  Twist h = Twist::Zero();

  NormalEquations& operator+=(const NormalEquations& other) {
    A += other.A;
    h += other.h;
    return *this;
  }
  NormalEquations& operator*=(double factor) {
    A *= factor;
    h *= factor;
    return *this;
  }

  /// A kernel's sums: the perturbation is in camera axes at the pose that the view was drawn at, about the same centre.
  static NormalEquations from_camera_axes(const Matrix6& A_camera, const Twist& h_camera, const Pose& T_drawn);
};

/// Turns vectors of perturbations from object axes to camera axes: y_camera = B y.
Matrix6 to_camera_axes(const Pose& T_camera_object);

}  // namespace holdfast
