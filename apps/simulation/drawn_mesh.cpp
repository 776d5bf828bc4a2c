#include "simulation/drawn_mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>

#include "simulation/light_encoding.hpp"

namespace holdfast::simulation {
namespace {

Eigen::Vector3f linear_color(const std::array<std::uint8_t, 4>& rgba) {
  return {static_cast<float>(linear_from_encoded(rgba[2] / 255.0)),
          static_cast<float>(linear_from_encoded(rgba[1] / 255.0)),
          static_cast<float>(linear_from_encoded(rgba[0] / 255.0))};
}

// Normals of each triangle's corners: area-weighted over the faces that meet there within the crease angle.
std::vector<std::array<Eigen::Vector3d, 3>> corner_normals(const Mesh& mesh) {
  const double crease_cosine = std::cos(40.0 * std::numbers::pi / 180.0);
  std::vector<Eigen::Vector3d> face(mesh.triangles.size());
  std::map<std::array<float, 3>, std::vector<std::size_t>> faces_at;
  const auto key = [&](std::uint32_t vertex) {
    const Eigen::Vector3f& p = mesh.positions[vertex];
    return std::array<float, 3>{p.x(), p.y(), p.z()};
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>();
    face[i] = (mesh.positions[t[1]].cast<double>() - a).cross(mesh.positions[t[2]].cast<double>() - a);
    for (const std::uint32_t vertex : t) faces_at[key(vertex)].push_back(i);
  }
  std::vector<std::array<Eigen::Vector3d, 3>> normals(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3d own = face[i].norm() > 0 ? face[i].normalized() : Eigen::Vector3d(0, 0, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      Eigen::Vector3d sum = own * 1e-30;  // a face without area still has a direction
      for (const std::size_t j : faces_at[key(mesh.triangles[i][k])]) {
        if (face[j].dot(own) >= crease_cosine * face[j].norm()) sum += face[j];
      }
      normals[i][k] = sum.normalized();
    }
  }
  return normals;
}

}  // namespace

DrawnMesh::DrawnMesh(const Mesh& mesh) {
  mesh.validate();
  std::vector<int> texture_of_material(mesh.materials.size(), -1);
  if (!mesh.texture_coordinates.empty()) {
    for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
      if (mesh.materials[i].texture.empty()) continue;
      texture_of_material[i] = static_cast<int>(textures_.size());
      textures_.emplace_back(mesh.materials[i].texture);
    }
    for (const Eigen::Vector2f& uv : mesh.texture_coordinates) {
      if (uv.minCoeff() < -1e-4f || uv.maxCoeff() > 1.0f + 1e-4f) repeats_ = true;
    }
  }
  const auto normals = corner_normals(mesh);
  triangles_.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle& t = triangles_[i];
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[i];
    t.texture = material < texture_of_material.size() ? texture_of_material[material] : -1;
    t.normals = normals[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[i][k];
      t.positions[k] = mesh.positions[vertex].cast<double>();
      t.texels[k].setZero();
      if (t.texture >= 0) {
        const MipTexture& texture = textures_[static_cast<std::size_t>(t.texture)];
        const Eigen::Vector2d uv = mesh.texture_coordinates[vertex].cast<double>();
        t.texels[k] = {uv.x() * texture.width() - 0.5, (1.0 - uv.y()) * texture.height() - 0.5};
      }
      t.colors[k] = mesh.colors.empty() ? Eigen::Vector3f::Constant(0.5f) : linear_color(mesh.colors[vertex]);
    }
  }
}

}  // namespace holdfast::simulation
