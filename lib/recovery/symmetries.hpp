#pragma once

#include <vector>

#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Turns about its centre that may leave a shape as it is, object axes: by a quarter and by half about its principal
/// axes. Which of them do is for a comparison with the frame to tell.
std::vector<Pose> possible_symmetries(const Mesh& mesh);

}  // namespace holdfast
