#pragma once

#include "holdfast/pose.hpp"

namespace holdfast {

/// The change of variables that kernels sum up with: translation in units of `radius`, rotation about
/// `p_camera_center`, camera axes (equation 11 of docs/math.md).
struct Conditioning {
  Eigen::Vector3d p_camera_center = Eigen::Vector3d::Zero();
  double radius = 1;
};

}  // namespace holdfast
