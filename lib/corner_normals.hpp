#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace holdfast {

/// Unit normals of every triangle's corners, towards its front: the mean, by their angles there, of the triangles at
/// the same position (whatever their texture) that face within 40 degrees of it. So what is round is smooth and edges
/// stay.
std::vector<std::array<Eigen::Vector3f, 3>> corner_normals(const std::vector<Eigen::Vector3d>& positions,
                                                           const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace holdfast
