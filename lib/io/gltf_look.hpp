#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "holdfast/mesh.hpp"
#include "io/gltf_document.hpp"
#include "io/mesh_assembly.hpp"

namespace holdfast::io {

/// What a glTF material shows without light: its base colour and texture.
struct GltfLook {
  std::string name;
  std::optional<std::size_t> image;
  bool emits_image = false;  ///< the material has a picture of what it emits
  bool lacks_image = false;  ///< the material's texture has none
  std::size_t coordinate_set = 0;
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();  ///< KHR_texture_transform: rotation and scale
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  Wrapping wrapping;
  std::array<double, 4> factor{1, 1, 1, 1};               ///< linear
  bool opaque = true;                                     ///< alpha means nothing
  std::optional<double> cutoff;                           ///< alpha from which on the surface is there, else it is not
  std::array<std::uint8_t, 4> color{255, 255, 255, 255};  ///< the factor alone, encoded

  /// The image, and all that is made of it: looks of the same have the same texture.
  std::string picture() const;
  /// Where a coordinate of the file lies in the texture, v upwards.
  Eigen::Vector2f place(float u, float v) const;
  /// The encoded colour of a vertex: the factor times 3 or 4 linear values, where there are some.
  std::array<std::uint8_t, 4> color_of(const float* values, std::size_t count) const;
};

/// Throws Error(file), and Error(model) where its texture is of a kind that is not supported.
GltfLook gltf_look(const GltfDocument& document, std::size_t material);

/// The texture times the factor. Throws Error(file).
Texture gltf_texture(GltfDocument& document, const GltfLook& look);

}  // namespace holdfast::io
