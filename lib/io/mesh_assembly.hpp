#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// A corner of a triangle as it stands in a model file.
struct Vertex {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Vector2f texture_coordinate = Eigen::Vector2f::Zero();
  std::array<std::uint8_t, 4> color{};  ///< alpha 0: none, surface that gives no constraints

  bool operator==(const Vertex&) const = default;
};

/// Makes a Mesh of triangles: identical vertices become one, triangles without area are left out. Vertices are compared
/// bit by bit (assimp's own joining merges what is up to 1e-5 units apart, too coarse for small objects in metres).
class MeshAssembly {
 public:
  MeshAssembly(bool with_texture_coordinates, bool with_colors)
      : with_texture_coordinates_(with_texture_coordinates), with_colors_(with_colors) {}

  void add_triangle(const std::array<Vertex, 3>& corners, std::uint32_t material);
  std::uint32_t add_material(Material material);
  /// Hands the mesh over; the assembly is empty afterwards.
  Mesh take();

 private:
  struct Hash {
    std::size_t operator()(const Vertex& vertex) const;
  };

  std::uint32_t index_of(const Vertex& vertex);

  bool with_texture_coordinates_;
  bool with_colors_;
  Mesh mesh_;
  std::unordered_map<Vertex, std::uint32_t, Hash> vertices_;
};

/// The texture file that a model names: beside the model, whatever slashes and escapes its exporter wrote; an absolute
/// path of the exporting machine falls back on the bare file name. Throws Error(file) naming it when it is missing.
std::filesystem::path find_texture(const std::filesystem::path& model, const std::string& name);

}  // namespace holdfast::io
