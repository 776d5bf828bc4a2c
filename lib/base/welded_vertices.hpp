#pragma once

#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// For every vertex the first one at its position and, when `by_texture`, with its texture coordinate too.
std::vector<std::uint32_t> welded_vertices(const Mesh& mesh, bool by_texture);

}  // namespace holdfast
