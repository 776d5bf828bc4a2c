#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// What of a mesh its levels keep.
enum class MeshAspect { appearance, shape };

/// A mesh with fewer triangles.
struct MeshLevel {
  std::vector<Eigen::Vector3d> positions;            ///< object frame, metres
  std::vector<Eigen::Vector2f> texture_coordinates;  ///< empty, or one a position
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> triangle_materials;  ///< empty, or one a triangle, as in the mesh
  /// By how much the surface, or by twice how much its texture, lies elsewhere where it is worst, metres: root of the
  /// mean square over what a vertex stands for.
  double deviation = 0;
};

/// Ever coarser levels, each of about 0.7 times the triangles of the one before, up to a deviation of a fiftieth of the
/// mesh's radius. Neighbouring vertices become one where that costs least, in the order of what it costs (quadrics of
/// Garland and Heckbert, 1997, with the texture's of Hoppe, 1999); of very many triangles nearest neighbours do first,
/// in that order by and large. Borders stay as they are, so no gap opens; so do, where levels keep the appearance,
/// texture seams and borders of materials. None for few triangles, nor, of the appearance, for vertex colours, which
/// vertices carry.
std::vector<MeshLevel> mesh_levels(const Mesh& mesh, MeshAspect aspect);

}  // namespace holdfast
