#pragma once

#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// The mip levels 1, 2, ... of a texture, each half the size of the one before (rounded down), down to 1x1. Colours are
/// averaged with alpha as weight, so that a texel never seen (alpha 0) does not leak its colour into its neighbours;
/// the alpha of a texel is the share of its area that was seen.
std::vector<Texture> texture_levels(const Texture& base);

}  // namespace holdfast
