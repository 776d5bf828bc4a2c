#pragma once

#include <Eigen/Core>

#include "holdfast/pose.hpp"

namespace holdfast::evaluation {

/// How far an estimated pose is off the true one. A pose that is not finite is infinitely far off.
struct PoseError {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< estimated minus true origin, camera axes, metres
  double rotation = 0;                                    ///< angle between the two rotations, radians

  double distance() const { return translation.norm(); }           ///< metres
  double lateral() const { return translation.head<2>().norm(); }  ///< across the optical axis, metres
  double depth() const;                                            ///< along the optical axis, metres, not negative
};

PoseError pose_error(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated);

/// A pose is within a tolerance when neither error exceeds it.
struct Tolerance {
  double translation = 0;  ///< metres
  double rotation = 0;     ///< radians
  bool holds(const PoseError& error) const;
};

/// A tolerance from the units it is usually quoted in.
Tolerance tolerance_mm_deg(double millimetres, double degrees);

/// e^T information e with e = log(T_estimated^-1 T_true): chi-squared with six degrees of freedom where the reported
/// covariance is right. Infinite where a pose is not finite.
double normalized_error_squared(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated,
                                const Matrix6& information);

/// 95 % quantile of chi-squared with six degrees of freedom.
inline constexpr double kChiSquared6At95 = 12.591587243743977;

/// Median of chi-squared with six degrees of freedom: what normalized_error_squared() should be in the middle.
inline constexpr double kChiSquared6Median = 5.348120627447120;

double to_degrees(double radians);
double to_radians(double degrees);

}  // namespace holdfast::evaluation
