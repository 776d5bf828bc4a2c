#pragma once

#include <vector>

#include "base/light_encoding.hpp"
#include "holdfast/mesh.hpp"

namespace holdfast {

/// The mip levels 1, 2, ... of a texture, each half the size of the one before (rounded down), down to 1x1. Colours are
/// averaged with alpha as weight, so that a texel never seen (alpha 0) does not leak its colour into its neighbours;
/// the alpha of a texel is the share of its area that was seen.
std::vector<Texture> texture_levels(const Texture& base);

/// The same, but what is averaged is the light that colours stand for, and softer: over four texels both ways, weighted
/// 1 3 3 1. Averages over two let pass what half the texels cannot show, which puts edges elsewhere as the object
/// moves. `repeat`: beyond a border lies the opposite one.
std::vector<Texture> light_levels(const Texture& base, bool repeat, const LightEncoding& encoding);

}  // namespace holdfast
