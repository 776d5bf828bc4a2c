#pragma once

#include <vector>

#include "base/corner_motion.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Turns about the axes of a surface of revolution, which its outline does not show: perturbations of one radian
/// (solve/normal_equations.hpp). None for other shapes, three for a sphere. Regular prisms of twelve sides are round.
std::vector<Twist> round_turns(const Mesh& mesh, const Extent& extent);

}  // namespace holdfast
