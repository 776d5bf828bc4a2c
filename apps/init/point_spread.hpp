#pragma once

#include <Eigen/Core>
#include <vector>

#include "init/point_pairs.hpp"

/// Spread in space of the model's points of some pairs.
namespace holdfast::app {

/// Their mean, object frame.
Eigen::Vector3d centroid(const std::vector<PointPair>& pairs);

bool are_collinear(const std::vector<PointPair>& pairs);
bool are_coplanar(const std::vector<PointPair>& pairs);

}  // namespace holdfast::app
