#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// A mesh with fewer triangles, between vertices of the original.
struct MeshLevel {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> triangle_materials;  ///< empty, or one a triangle, as in the mesh
  /// By how much surface or texture lie elsewhere where it is worst, metres: root of the mean square over what a vertex
  /// stands for.
  double deviation = 0;
};

/// Ever coarser levels, each of about half the triangles of the one before, up to a deviation of a fiftieth of the
/// mesh's radius. Interior vertices are merged into neighbours in the order of what that costs (quadrics of Garland and
/// Heckbert, 1997, with the texture's of Hoppe, 1999); borders, texture seams and borders of materials stay as they
/// are, so no gap opens. None for few triangles and for vertex colours, which vertices carry.
std::vector<MeshLevel> mesh_levels(const Mesh& mesh);

}  // namespace holdfast
