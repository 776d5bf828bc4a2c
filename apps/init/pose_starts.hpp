#pragma once

#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

/// Poses to refine from: closed forms, and one for each of the 24 ways to put a cube, so that no minimum goes unseen.
std::vector<Pose> pose_starts(const std::vector<PointPair>& pairs, const Camera& camera);

/// For each pair whether it agrees within so many pixels with most others to a pose with this camera; all false: there
/// are no such.
std::vector<bool> agreeing(const std::vector<PointPair>& pairs, const Camera& camera, double pixels);

}  // namespace holdfast::app
