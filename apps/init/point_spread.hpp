#pragma once

#include <Eigen/Core>
#include <vector>

#include "init/point_pairs.hpp"

/// How the model's points of some pairs lie in space.
namespace holdfast::app {

/// Their mean, object frame.
Eigen::Vector3d centroid(const std::vector<PointPair>& pairs);

bool are_collinear(const std::vector<PointPair>& pairs);
bool are_coplanar(const std::vector<PointPair>& pairs);

}  // namespace holdfast::app
