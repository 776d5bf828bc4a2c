#include "drawn_levels.hpp"

#include <algorithm>
#include <utility>

#include "corner_normals.hpp"
#include "mesh_levels.hpp"

namespace holdfast {
namespace {

std::size_t material_count(const Mesh& mesh) { return std::max<std::size_t>(mesh.materials.size(), 1); }

MeshLevel whole(const Mesh& mesh) {
  MeshLevel level{{}, mesh.texture_coordinates, mesh.triangles, mesh.triangle_materials, 0};
  for (const Eigen::Vector3f& p : mesh.positions) level.positions.emplace_back(p.cast<double>());
  return level;
}

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

/// The triangles by material, in their order within one; describes the ranges.
std::vector<std::uint32_t> by_material(const MeshLevel& level, std::size_t materials, std::vector<Batch>& batches) {
  std::vector<std::size_t> next(materials + 1, 0);
  for (std::size_t i = 0; i < level.triangles.size(); ++i) ++next[material_of(level.triangle_materials, i) + 1];
  for (std::size_t material = 0; material < materials; ++material) {
    if (next[material + 1] > 0) {
      batches.push_back({material, static_cast<int>(3 * next[material + 1]), 3 * next[material]});
    }
    next[material + 1] += next[material];
  }
  std::vector<std::uint32_t> order(level.triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[next[material_of(level.triangle_materials, i)]++] = static_cast<std::uint32_t>(i);
  }
  return order;
}

/// `vertices`: the level's, without normals; `lit`: they get some.
DrawnLevel drawn(const MeshLevel& level, std::size_t materials, const std::vector<Vertex>& vertices, bool lit) {
  DrawnLevel made;
  made.deviation = level.deviation;
  std::vector<std::array<Eigen::Vector3f, 3>> normals;
  if (lit) normals = corner_normals(level.positions, level.triangles);
  // Of each vertex what was made of it so far, with one normal and another: the newest, and the one made before each.
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> newest(vertices.size(), kNone), before;
  made.indices.reserve(3 * level.triangles.size());
  for (const std::uint32_t triangle : by_material(level, materials, made.batches)) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t index = level.triangles[triangle][corner];
      std::array<float, 3> normal{};
      if (lit) Eigen::Vector3f::Map(normal.data()) = normals[triangle][corner];
      std::uint32_t place = newest[index];
      while (place != kNone && made.vertices[place].normal != normal) place = before[place];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(made.vertices.size());
        made.vertices.push_back(vertices[index]);
        made.vertices.back().normal = normal;
        before.push_back(std::exchange(newest[index], place));
      }
      made.indices.push_back(place);
    }
  }
  return made;
}

}  // namespace

DrawnLevel drawn_mesh(const Mesh& mesh, const Eigen::Vector3d& center) {
  const MeshLevel level = whole(mesh);
  std::vector<Vertex> vertices = make_vertices(level, center);
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) vertices[i].color = mesh.colors[i];
  return drawn(level, material_count(mesh), vertices, true);
}

std::vector<DrawnLevel> coarser_levels(const Mesh& mesh, MeshAspect aspect, const Eigen::Vector3d& center) {
  std::vector<DrawnLevel> levels;
  const bool lit = aspect == MeshAspect::appearance;
  for (const MeshLevel& level : mesh_levels(mesh, aspect)) {
    levels.push_back(drawn(level, material_count(mesh), make_vertices(level, center), lit));
  }
  return levels;
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
