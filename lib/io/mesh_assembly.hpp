#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "holdfast/mesh.hpp"
#include "io/texture_wrap.hpp"

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

  /// Throws Error(model) for more than ten million, those without area too.
  void add_triangle(const std::array<Vertex, 3>& corners, std::uint32_t material);
  /// A texture that is not repeated beyond its borders is drawn larger, so that a renderer that repeats shows the same.
  std::uint32_t add_material(Material material, const Wrapping& wrapping = {});
  /// The material that shows a picture file; of the same one, wrapped the same way, there is one, named by the first:
  /// each copy would take the picture's memory here and in OpenGL. Throws Error(file).
  std::uint32_t add_picture(const std::filesystem::path& file, const std::string& name, const Wrapping& wrapping = {});
  /// The same of a picture that is made by `load`; `picture` says of what.
  std::uint32_t add_picture(const std::string& picture, const std::string& name, const Wrapping& wrapping,
                            const std::function<Texture()>& load);
  /// Hands the mesh over; the assembly is empty afterwards. Throws Error(model) for a texture that would be too large.
  Mesh take();

 private:
  struct Hash {
    std::size_t operator()(const Vertex& vertex) const;
  };

  struct Wrapped {
    Wrapping wrapping;
    std::vector<std::array<Vertex, 3>> triangles;  ///< that wait for all coordinates to be known
  };

  std::uint32_t index_of(const Vertex& vertex);
  void append(const std::array<Vertex, 3>& corners, std::uint32_t material);

  bool with_texture_coordinates_;
  bool with_colors_;
  Mesh mesh_;
  std::size_t added_ = 0;                     ///< triangles, those without area too
  std::map<std::uint32_t, Wrapped> wrapped_;  ///< by material
  std::map<std::pair<std::string, Wrapping>, std::uint32_t> pictures_;
  std::unordered_map<Vertex, std::uint32_t, Hash> vertices_;
};

}  // namespace holdfast::io
