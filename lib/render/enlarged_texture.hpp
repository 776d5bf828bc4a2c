#pragma once

#include <vector>

#include "base/light_encoding.hpp"
#include "holdfast/mesh.hpp"

namespace holdfast {

/// Texture coordinates' area a square metre of surface, a material each; 0 where nothing is drawn with it.
std::vector<double> texture_densities(const Mesh& mesh);

/// How many times as many texels, both ways, a texture should have: 1, 2 or 4, so that a texel is no longer than
/// `longest` metres, as far as memory allows.
int enlargement(const Texture& texture, double density, double longest, int largest_side);

/// The texture with `times` as many texels both ways, between which light is interpolated linearly. Drawn with linear
/// interpolation of encoded values it then looks as if light had been interpolated. `repeat`: beyond a border lies the
/// opposite one.
Texture enlarged(const Texture& texture, int times, bool repeat, const LightEncoding& encoding);

}  // namespace holdfast
