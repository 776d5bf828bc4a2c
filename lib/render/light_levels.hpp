#pragma once

#include <vector>

#include "base/light_encoding.hpp"
#include "holdfast/mesh.hpp"

namespace holdfast {

/// Like texture_levels(), but what is averaged is the light that colours stand for, and softer: over four texels both
/// ways, weighted 1 3 3 1. Averages over two let pass what half the texels cannot show, which puts edges elsewhere as
/// the object moves. `repeat`: beyond a border lies the opposite one.
std::vector<Texture> light_levels(const Texture& base, bool repeat, const LightEncoding& encoding);

}  // namespace holdfast
