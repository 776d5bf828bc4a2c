#pragma once

#include <array>
#include <cstddef>

#include "base/corner_motion.hpp"
#include "holdfast/pose.hpp"
#include "motion/restlessness.hpp"

namespace holdfast {

/// Where the object is expected and how surely.
struct MotionPrior {
  Pose T_camera_object = Pose::Identity();
  /// Of the perturbation from there (normal_equations.hpp).
  Matrix6 covariance = Matrix6::Identity();
};

/// Pose, velocity and their 12x12 covariance: the object's centre moves on at its velocity, its orientation turns on at
/// its angular velocity, both change at random (equations 12b and 12c of docs/math.md). Covariances are of
/// perturbations: object axes, object radii and radians. Times are seconds, or frames where frames carry no time.
class MotionFilter {
 public:
  explicit MotionFilter(const Extent& extent) : extent_(extent) {}

  /// At about this pose; the velocity is unknown.
  void reset(const Pose& T_camera_object);

  /// The pose of reset() is the one at time t.
  void begin(double t);

  const Pose& pose() const { return T_; }
  /// Whether two poses in a row have told a velocity.
  bool moving() const { return updates_ > 1; }
  /// Whether any frame has been seen since reset().
  bool started() const { return started_; }
  bool lost() const { return misses_ > 0; }
  int misses() const { return misses_; }

  /// The pose at time t and its covariance. A lost object goes on as it moved for a while, then stops.
  MotionPrior predict(double t) const;
  /// The frame at time t was seen, and its pose, with the prediction counted in, is known this well.
  void update(const Pose& T_camera_object, const Matrix6& covariance, double t);
  /// The object was not found in the frame at time t.
  void miss(double t);

  /// Square of a usual step away from the prediction, object radii and radians; from innovations.
  double usual_innovation_squared() const { return usual_innovation_squared_; }
  /// Covariance that acceleration while the shutter is open adds to a pose; a share of the time between frames.
  Matrix6 within_exposure(double exposure) const { return restlessness_.within(exposure); }

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  /// Constant velocity, as last changed where `changing`.
  Pose gone_on(double dt, bool changing) const;
  /// The time that motion goes on until t, bounded for a lost object.
  double going_on(double t) const;
  Matrix12 propagated(double dt) const;
  void rest();

  Extent extent_;
  Pose T_ = Pose::Identity();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();          ///< of the centre, camera axes, metres per unit of time
  Eigen::Vector3d angular_velocity_ = Eigen::Vector3d::Zero();  ///< camera axes, radians per unit of time
  Eigen::Vector3d velocity_change_ = Eigen::Vector3d::Zero();   ///< of the last frame, expected to go on changing so
  Eigen::Vector3d angular_change_ = Eigen::Vector3d::Zero();
  Matrix12 covariance_ = Matrix12::Identity();  ///< of pose and velocity (per step_)
  double t_ = 0;
  double step_ = 1;  ///< usual time between frames
  double usual_innovation_squared_ = 0;
  Restlessness restlessness_;
  std::array<double, 12> strays_{};  ///< from constant velocity, of the last frames
  std::size_t stray_count_ = 0;
  bool changing_ = false;  ///< the velocity's last change is expected to go on
  int updates_ = 0, misses_ = 0;
  bool started_ = false;
};

}  // namespace holdfast
