#include "base/one_color.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace holdfast {
namespace {

/// Levels of 255 by which colours that are alike may differ, a channel: what compression makes of one.
constexpr int kAlike = 8;

}  // namespace

bool is_of_one_color(const Mesh& mesh) {
  std::array<int, 3> least{255, 255, 255}, most{0, 0, 0};
  const auto alike = [&](const std::uint8_t* rgba) {  // false once some channel spans too much
    for (std::size_t channel = 0; channel < 3 && rgba[3] >= kKnownAlpha; ++channel) {
      least[channel] = std::min<int>(least[channel], rgba[channel]);
      most[channel] = std::max<int>(most[channel], rgba[channel]);
      if (most[channel] - least[channel] > kAlike) return false;
    }
    return true;
  };
  for (const auto& color : mesh.colors) {
    if (!alike(color.data())) return false;
  }
  for (const Material& material : mesh.materials) {
    const std::vector<std::uint8_t>& rgba = material.texture.rgba;
    for (std::size_t i = 0; i + 4 <= rgba.size(); i += 4) {
      if (!alike(rgba.data() + i)) return false;
    }
  }
  return true;
}

}  // namespace holdfast
