#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "holdfast/export.hpp"

namespace holdfast {

/// Least alpha of what is known of a surface, as in model.frag. What is more transparent was never seen, or what is
/// seen through it changes: it is drawn, since it hides what lies behind it, but gives no constraints.
inline constexpr std::uint8_t kKnownAlpha = 250;

/// RGBA image, rows from the top (v = 1) down.
struct Texture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< width * height * 4 bytes
  bool empty() const { return rgba.empty(); }
};

/// What covers a set of triangles. Without texture and without vertex colours a surface gives no
/// constraints but those of its outline, where no other surface of the mesh has any.
struct Material {
  std::string name;
  Texture texture;
};

/// Triangle mesh, metres, object frame.
struct HOLDFAST_EXPORT Mesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector2f> texture_coordinates;     ///< empty, or one a vertex; OpenGL's convention, v upwards
  std::vector<std::array<std::uint8_t, 4>> colors;      ///< empty, or one RGBA a vertex; used where there is no texture
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< vertex indices
  std::vector<std::uint32_t> triangle_materials;        ///< empty (all of material 0), or one index a triangle
  std::vector<Material> materials;                      ///< may be empty: no textures

  /// Centre of the axis-aligned bounding box, metres.
  Eigen::Vector3d center() const;
  /// Largest distance of a vertex from center(), metres.
  double radius() const;
  /// True when at least one triangle has a texture or vertex colours.
  bool has_appearance() const;

  /// Throws Error(model) for no triangles, NaN or infinite coordinates, indices out of range, sizes that do not match,
  /// or a mesh of no extent.
  void validate() const;
};

}  // namespace holdfast
