#pragma once

#include "holdfast/mesh.hpp"

namespace holdfast {

/// Whether all vertex colours and texels of a mesh are alike, so that there is nothing on it to follow.
bool is_of_one_color(const Mesh& mesh);

}  // namespace holdfast
