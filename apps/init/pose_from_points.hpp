#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

struct PoseFromPoints {
  Pose T_camera_object = Pose::Identity();
  Camera camera;                           ///< as given, or with the focal length found
  std::vector<PointPair> pairs;            ///< those that the pose is of; mistaken ones are left out, with a warning
  std::vector<Eigen::Vector2d> residuals;  ///< projected minus seen, pixels, one of these pairs
  double rms = 0;                          ///< root of the mean squared length of the residuals, pixels
  double position_sigma = 0;               ///< standard deviation of the points' middle, metres
  double rotation_sigma = 0;               ///< the same of the rotation, radians
  double focal_sigma = 0;                  ///< standard deviation of an estimated focal length, pixels
  std::vector<std::string> warnings;       ///< what the user should know about this pose
};

/// The pose that sees the points at their pixels, least squares of the pixels' distances. Four or more pairs. Where
/// most pairs, and one more than that, agree, others that do not are left out. Throws Error(pose) when the pairs do not
/// determine a pose with all points before the camera.
PoseFromPoints pose_from_points(const std::vector<PointPair>& pairs, const Camera& camera);

/// Pose and focal length for frames of this size: square pixels, principal point at the image centre, no distortion.
/// Six or more pairs; throws Error(pose) as above or when they do not determine the focal length.
PoseFromPoints pose_and_focal_from_points(const std::vector<PointPair>& pairs, int width, int height);

}  // namespace holdfast::app
