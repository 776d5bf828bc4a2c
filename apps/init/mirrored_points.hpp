#pragma once

#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

/// A doubt where pairs whose pose is `rms` pixels off fit several times better with u and v exchanged, or
/// with one of the model's axes negated: a mirror image of a shape fits its picture to some pixels.
std::optional<std::string> mirrored_points(const std::vector<PointPair>& pairs, const Camera& camera, double rms);

}  // namespace holdfast::app
