#pragma once

#include "holdfast/mesh.hpp"

namespace holdfast {

/// Whether the triangles enclose a volume and all turn their front (corners counter-clockwise, seen from outside)
/// outwards, so that nothing of their backs can ever be seen from outside. Vertices at the same position count as one,
/// because texture seams split them. False when in doubt.
bool is_closed_outward(const Mesh& mesh);

}  // namespace holdfast
