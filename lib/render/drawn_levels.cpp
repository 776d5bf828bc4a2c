#include "render/drawn_levels.hpp"

#include <algorithm>

namespace holdfast {
namespace {

std::size_t material_count(const Mesh& mesh) { return std::max<std::size_t>(mesh.materials.size(), 1); }

std::vector<Vertex> make_vertices(const MeshLevel& level, const Eigen::Vector3d& center) {
  std::vector<Vertex> vertices(level.positions.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f position = (level.positions[i] - center).cast<float>();
    vertices[i].position = {position.x(), position.y(), position.z()};
    if (!level.texture_coordinates.empty()) {
      // Texture rows are uploaded from the top, so the coordinate runs downwards.
      vertices[i].texture_coordinate = {level.texture_coordinates[i].x(), 1 - level.texture_coordinates[i].y()};
    }
  }
  return vertices;
}

std::uint32_t material_of(const std::vector<std::uint32_t>& materials, std::size_t triangle) {
  return materials.empty() ? 0 : materials[triangle];
}

/// Sorts the triangles by material (keeping their order within one) and describes the ranges.
std::vector<std::uint32_t> make_indices(const MeshLevel& level, std::size_t materials, std::vector<Batch>& batches) {
  std::vector<std::size_t> next(materials + 1, 0);
  for (std::size_t i = 0; i < level.triangles.size(); ++i) {
    next[material_of(level.triangle_materials, i) + 1] += 3;
  }
  for (std::size_t material = 0; material < materials; ++material) {
    if (next[material + 1] > 0) {
      batches.push_back({material, static_cast<int>(next[material + 1]), next[material]});
    }
    next[material + 1] += next[material];
  }
  std::vector<std::uint32_t> indices(level.triangles.size() * 3);
  for (std::size_t i = 0; i < level.triangles.size(); ++i) {
    std::size_t& position = next[material_of(level.triangle_materials, i)];
    std::copy(level.triangles[i].begin(), level.triangles[i].end(),
              indices.begin() + static_cast<std::ptrdiff_t>(position));
    position += 3;
  }
  return indices;
}

/// The vertices that are used, in the order of their use.
std::vector<Vertex> used_vertices(const std::vector<Vertex>& vertices, std::vector<std::uint32_t>& indices) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> place(vertices.size(), kUnused);
  std::vector<Vertex> used;
  for (std::uint32_t& index : indices) {
    if (place[index] == kUnused) {
      place[index] = static_cast<std::uint32_t>(used.size());
      used.push_back(vertices[index]);
    }
    index = place[index];
  }
  return used;
}

DrawnLevel as_drawn(const MeshLevel& level, const std::vector<Vertex>& vertices, const Mesh& mesh) {
  DrawnLevel drawn;
  drawn.indices = make_indices(level, material_count(mesh), drawn.batches);
  drawn.vertices = used_vertices(vertices, drawn.indices);
  drawn.deviation = level.deviation;
  return drawn;
}

}  // namespace

DrawnLevel drawn_mesh(const Mesh& mesh, const Eigen::Vector3d& center) {
  MeshLevel whole{{}, mesh.texture_coordinates, mesh.triangles, mesh.triangle_materials, 0};
  for (const Eigen::Vector3f& p : mesh.positions) whole.positions.emplace_back(p.cast<double>());
  std::vector<Vertex> vertices = make_vertices(whole, center);
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) vertices[i].color = mesh.colors[i];
  return as_drawn(whole, vertices, mesh);
}

std::vector<DrawnLevel> coarser_levels(const Mesh& mesh, MeshAspect aspect, const Eigen::Vector3d& center) {
  std::vector<DrawnLevel> drawn;
  for (const MeshLevel& level : mesh_levels(mesh, aspect)) {
    drawn.push_back(as_drawn(level, make_vertices(level, center), mesh));
  }
  return drawn;
}

std::vector<bool> repeating_materials(const Mesh& mesh) {
  constexpr float kRounding = 1e-3F;
  std::vector<bool> repeat(material_count(mesh), false);
  if (mesh.texture_coordinates.empty()) {
    return repeat;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      const Eigen::Vector2f& t = mesh.texture_coordinates[index];
      if (t.minCoeff() < -kRounding || t.maxCoeff() > 1 + kRounding) {
        repeat[material_of(mesh.triangle_materials, i)] = true;
      }
    }
  }
  return repeat;
}

}  // namespace holdfast
