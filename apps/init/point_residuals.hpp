#pragma once

#include <Eigen/Core>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

/// Projected minus seen, pixels, one a pair. Points behind the camera have no residual: NaN.
std::vector<Eigen::Vector2d> point_residuals(const std::vector<PointPair>& pairs, const Camera& camera,
                                             const Pose& T_camera_object);

/// Root of the mean squared length; NaN with NaN among them.
double root_mean_square(const std::vector<Eigen::Vector2d>& residuals);

}  // namespace holdfast::app
