#pragma once

#include "holdfast/mesh.hpp"

namespace holdfast {

/// All vertex colours and texels of the mesh that are known are alike: nothing on it is to be followed.
bool is_of_one_color(const Mesh& mesh);

}  // namespace holdfast
