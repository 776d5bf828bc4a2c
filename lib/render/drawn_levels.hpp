#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"
#include "render/mesh_levels.hpp"

namespace holdfast {

struct Vertex {
  std::array<float, 3> position{};
  std::array<float, 2> texture_coordinate{};
  std::array<std::uint8_t, 4> color{};
};

/// Triangles that share a material, as a range of the index buffer.
struct Batch {
  std::size_t material = 0;
  int index_count = 0;
  std::size_t first_index = 0;
};

/// The mesh, or a coarser level of it, as it is drawn.
struct DrawnLevel {
  std::vector<Vertex> vertices;  ///< in the order of their use
  std::vector<std::uint32_t> indices;
  std::vector<Batch> batches;
  double deviation = 0;  ///< from the mesh, metres
};

/// Positions are taken about `center`, so that a model far from its origin keeps its digits in float.
DrawnLevel drawn_mesh(const Mesh& mesh, const Eigen::Vector3d& center);

/// The mesh_levels() of the mesh.
std::vector<DrawnLevel> coarser_levels(const Mesh& mesh, MeshAspect aspect, const Eigen::Vector3d& center);

/// A flag a material. Coordinates that leave the image ask for repetition; otherwise repeating would bleed the opposite
/// border in.
std::vector<bool> repeating_materials(const Mesh& mesh);

}  // namespace holdfast
