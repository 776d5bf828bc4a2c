#pragma once

#include <Eigen/Core>

#include "holdfast/mesh.hpp"

namespace holdfast::app {

/// Distance of a point from a mesh's surface, metres, inside or outside.
double distance_to_surface(const Mesh& mesh, const Eigen::Vector3d& point);

}  // namespace holdfast::app
