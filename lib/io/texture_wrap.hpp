#pragma once

#include <compare>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// What is seen of a texture beyond its borders.
enum class Wrap { repeat, mirror, clamp };

struct Wrapping {
  Wrap u = Wrap::repeat;
  Wrap v = Wrap::repeat;
  auto operator<=>(const Wrapping&) const = default;
};

/// Draws a material's texture so large that these coordinates, which change with it, show the same where it is
/// repeated. Throws Error(model) where it would be larger than 64 million texels.
void wrap_texture(Material& material, const Wrapping& wrapping, const std::vector<Eigen::Vector2f*>& coordinates);

}  // namespace holdfast::io
