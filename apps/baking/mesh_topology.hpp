#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::baking {

/// How the triangles of a mesh hang together. Vertices at the same place count as one, whatever else tells them apart.
struct MeshTopology {
  /// Triangles across each edge (edge k runs from corner k to the next); -1 at a border or where more than two meet.
  std::vector<std::array<std::int32_t, 3>> neighbors;
  std::vector<Eigen::Vector3d> normals;  ///< a triangle, unit length; zero where it has no area
  std::vector<double> areas;             ///< a triangle, square metres
  /// The surface has no border and is wound one way throughout: a triangle whose back is turned is never seen.
  bool closed = false;
  /// Closed, and wound so that the normals point inwards.
  bool inside_out = false;
};

/// Throws Error(model) for a mesh that validate() refuses.
MeshTopology topology_of(const Mesh& mesh);

}  // namespace holdfast::baking
