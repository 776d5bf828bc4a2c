#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace holdfast::io {

/// A flat polygon's triangles as indices of its corners, which keep its sense of turning. Fewer than three corners make
/// none; a corner that turns inwards is no obstacle.
std::vector<std::array<std::size_t, 3>> triangles_of_polygon(const std::vector<Eigen::Vector3f>& corners);

}  // namespace holdfast::io
