#include "io/mesh_assembly.hpp"

#include <utility>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"

namespace holdfast::io {
namespace {

constexpr std::size_t kMostTriangles = 10'000'000;  // a short file may use one mesh any number of times

}  // namespace

std::size_t MeshAssembly::Hash::operator()(const Vertex& vertex) const {
  std::size_t hash = 0;
  for (const float value : {vertex.position.x(), vertex.position.y(), vertex.position.z(),
                            vertex.texture_coordinate.x(), vertex.texture_coordinate.y()}) {
    hash = hash * 1000003 ^ std::hash<float>()(value);
  }
  return hash;
}

std::uint32_t MeshAssembly::index_of(const Vertex& vertex) {
  const auto [entry, is_new] = vertices_.try_emplace(vertex, static_cast<std::uint32_t>(mesh_.positions.size()));
  if (is_new) {
    mesh_.positions.push_back(vertex.position);
    if (with_texture_coordinates_) {
      mesh_.texture_coordinates.push_back(vertex.texture_coordinate);
    }
    if (with_colors_) {
      mesh_.colors.push_back(vertex.color);
    }
  }
  return entry->second;
}

void MeshAssembly::add_triangle(const std::array<Vertex, 3>& corners, std::uint32_t material) {
  if (++added_ > kMostTriangles) {
    throw Error(ErrorCode::model, "a model of more than 10 million triangles: simplify it");
  }
  const auto wrapped = wrapped_.find(material);
  if (wrapped != wrapped_.end()) {
    wrapped->second.triangles.push_back(corners);
  } else {
    append(corners, material);
  }
}

void MeshAssembly::append(const std::array<Vertex, 3>& corners, std::uint32_t material) {
  const std::array<std::uint32_t, 3> triangle{index_of(corners[0]), index_of(corners[1]), index_of(corners[2])};
  const auto& [a, b, c] = triangle;
  if (a != b && b != c && c != a) {
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_materials.push_back(material);
  }
}

std::uint32_t MeshAssembly::add_material(Material material, const Wrapping& wrapping) {
  const auto index = static_cast<std::uint32_t>(mesh_.materials.size());
  if (!material.texture.empty() && wrapping != Wrapping{}) {
    wrapped_[index].wrapping = wrapping;
  }
  mesh_.materials.push_back(std::move(material));
  return index;
}

std::uint32_t MeshAssembly::add_picture(const std::filesystem::path& file, const std::string& name,
                                        const Wrapping& wrapping) {
  return add_picture(std::filesystem::weakly_canonical(file).string(), name, wrapping,
                     [&file] { return load_texture(file); });
}

std::uint32_t MeshAssembly::add_picture(const std::string& picture, const std::string& name, const Wrapping& wrapping,
                                        const std::function<Texture()>& load) {
  const std::pair key{picture, wrapping};
  if (const auto known = pictures_.find(key); known != pictures_.end()) return known->second;
  return pictures_[key] = add_material({name, load()}, wrapping);
}

Mesh MeshAssembly::take() {
  for (auto& [material, wrapped] : wrapped_) {
    std::vector<Eigen::Vector2f*> coordinates;
    for (std::array<Vertex, 3>& corners : wrapped.triangles) {
      for (Vertex& corner : corners) coordinates.push_back(&corner.texture_coordinate);
    }
    wrap_texture(mesh_.materials[material], wrapped.wrapping, coordinates);
    for (const std::array<Vertex, 3>& corners : wrapped.triangles) append(corners, material);
  }
  wrapped_.clear();
  vertices_.clear();
  pictures_.clear();
  added_ = 0;
  return std::exchange(mesh_, {});
}

}  // namespace holdfast::io
