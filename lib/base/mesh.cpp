#include "holdfast/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast {
namespace {

/// Of the squared radius: a smaller cross product of a triangle's sides is rounding.
constexpr double kLeastArea = 1e-12;

Eigen::AlignedBox3d bounding_box(const std::vector<Eigen::Vector3f>& positions) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& position : positions) {
    box.extend(position.cast<double>());
  }
  return box;
}

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorCode::model, "model: " + message); }

void validate_texture(const Texture& texture, std::size_t material) {
  const bool sized = texture.width > 0 && texture.height > 0;
  const std::size_t bytes =
      sized ? static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height) * 4 : 0;
  if (!texture.empty() && texture.rgba.size() != bytes) {
    fail("the texture of material " + std::to_string(material) + " is " + std::to_string(texture.width) + "x" +
         std::to_string(texture.height) + " pixels but holds " + std::to_string(texture.rgba.size()) +
         " bytes; give width * height * 4 bytes of RGBA");
  }
}

}  // namespace

Eigen::Vector3d Mesh::center() const {
  if (positions.empty()) {
    return Eigen::Vector3d::Zero();
  }
  return bounding_box(positions).center();
}

double Mesh::radius() const {
  const Eigen::Vector3d middle = center();
  double squared = 0;
  for (const Eigen::Vector3f& position : positions) {
    squared = std::max(squared, (position.cast<double>() - middle).squaredNorm());
  }
  return std::sqrt(squared);
}

bool Mesh::has_appearance() const {
  if (triangles.empty()) {
    return false;
  }
  if (!colors.empty()) {
    return true;
  }
  if (texture_coordinates.empty() || materials.empty()) {
    return false;
  }
  if (triangle_materials.empty()) {
    return !materials.front().texture.empty();
  }
  return std::any_of(triangle_materials.begin(), triangle_materials.end(), [this](std::uint32_t material) {
    return material < materials.size() && !materials[material].texture.empty();
  });
}

void Mesh::validate() const {
  if (triangles.empty()) {
    fail("the mesh has no triangles; export it with faces, not as a point cloud or lines");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!positions[i].allFinite()) {
      fail("vertex " + std::to_string(i) + " has a NaN or infinite coordinate; repair the mesh");
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::uint32_t index : triangles[i]) {
      if (index >= positions.size()) {
        fail("triangle " + std::to_string(i) + " refers to vertex " + std::to_string(index) + ", but there are " +
             std::to_string(positions.size()) + " vertices; repair the mesh");
      }
    }
  }
  if (!texture_coordinates.empty() && texture_coordinates.size() != positions.size()) {
    fail(std::to_string(texture_coordinates.size()) + " texture coordinates for " + std::to_string(positions.size()) +
         " vertices; give one a vertex or none");
  }
  for (std::size_t i = 0; i < texture_coordinates.size(); ++i) {
    if (!texture_coordinates[i].allFinite()) {
      fail("vertex " + std::to_string(i) + " has a NaN or infinite texture coordinate; repair the mesh");
    }
  }
  if (!colors.empty() && colors.size() != positions.size()) {
    fail(std::to_string(colors.size()) + " vertex colours for " + std::to_string(positions.size()) +
         " vertices; give one a vertex or none");
  }
  if (!triangle_materials.empty() && triangle_materials.size() != triangles.size()) {
    fail(std::to_string(triangle_materials.size()) + " material indices for " + std::to_string(triangles.size()) +
         " triangles; give one a triangle or none");
  }
  const std::size_t material_count = std::max<std::size_t>(materials.size(), 1);
  for (std::size_t i = 0; i < triangle_materials.size(); ++i) {
    if (triangle_materials[i] >= material_count) {
      fail("triangle " + std::to_string(i) + " refers to material " + std::to_string(triangle_materials[i]) +
           ", but there are " + std::to_string(material_count) + " materials; repair the mesh");
    }
  }
  for (std::size_t i = 0; i < materials.size(); ++i) {
    validate_texture(materials[i].texture, i);
    if (!materials[i].texture.empty() && texture_coordinates.empty()) {
      fail("material " + std::to_string(i) +
           " has a texture, but the mesh has no texture coordinates; give one a vertex");
    }
  }
  if (!(radius() > 0)) {
    fail("the mesh has no extent (all vertices in one point); check its unit and its export");
  }
  const auto area = [this](const auto& triangle) {
    const Eigen::Vector3d a = positions[triangle[0]].template cast<double>();
    return (positions[triangle[1]].template cast<double>() - a)
        .cross(positions[triangle[2]].template cast<double>() - a)
        .norm();
  };
  const double least = kLeastArea * radius() * radius();
  if (std::none_of(triangles.begin(), triangles.end(), [&](const auto& t) { return area(t) > least; })) {
    fail("the mesh has no triangle with an area (their corners lie on lines); check its export");
  }
}

}  // namespace holdfast
