#pragma once

#include <Eigen/Core>
#include <array>

#include "simulation/motion.hpp"

namespace holdfast::simulation {

/// Where an object is and how it is turned, in numbers that always put it into view.
struct Placement {
  double across = 0;                               ///< -1: as far left as the object fits, 1: as far right
  double down = 0;                                 ///< -1: as high as it fits, 1: as low
  double distance = 0;                             ///< -1: nearest, 1: farthest
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector from the middle orientation, camera axes
};

/// Straight on from one pose to another.
Pose between(const Pose& from, const Pose& to, double share);

/// What an object moves in: the camera's view, between a nearest and a farthest distance.
class Stage {
 public:
  /// Throws Error(invalid_argument) where the distances do not fit the object.
  Stage(const MotionOptions& options, const Mesh& mesh, const Camera& camera);

  Pose pose(const Placement& placement) const;
  /// The farthest that any corner's image moves, pixels.
  double motion(const Pose& a, const Pose& b) const { return corner_motion(corners_, camera_, a, b); }
  /// Image motion of all corners in pixels, as one vector.
  Eigen::Matrix<double, 16, 1> flow(const Pose& a, const Pose& b) const;
  bool in_view(const Pose& pose) const;
  Eigen::Vector3d center_camera(const Pose& pose) const { return pose * center_; }

 private:
  Eigen::Vector2d pixel(const Eigen::Vector3d& p) const;

  Camera camera_;
  std::array<Eigen::Vector3d, 8> corners_;
  MotionOptions options_;
  Eigen::Vector3d center_;
  Eigen::Vector3d half_size_;
};

}  // namespace holdfast::simulation
