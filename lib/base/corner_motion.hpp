#pragma once

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Where an object is and how large, in its own frame, metres.
struct Extent {
  Eigen::Vector3d p_object_center = Eigen::Vector3d::Zero();
  double radius = 0;
};

/// How far apart, at most, two poses put the corners of a cube of the object's size in the picture, pixels: what a
/// rotation or translation moves at its surface. Corners nearer than half as far as its centre are taken to be there.
/// 1e9 where either puts the centre behind the camera.
double corner_motion(const Extent& extent, const Camera& camera, const Pose& T_a, const Pose& T_b);

}  // namespace holdfast
