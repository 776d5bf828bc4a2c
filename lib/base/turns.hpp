#pragma once

#include <Eigen/Core>
#include <vector>

#include "holdfast/pose.hpp"

namespace holdfast {

/// The pose turned like this that has a point of the object there.
inline Pose anchored(const Eigen::Matrix3d& R_camera_object, const Eigen::Vector3d& p_object,
                     const Eigen::Vector3d& p_camera) {
  Pose T = Pose::Identity();
  T.linear() = R_camera_object;
  T.translation() = p_camera - R_camera_object * p_object;
  return T;
}

/// The angle between two poses' rotations, radians.
inline double turn_between(const Pose& a, const Pose& b) { return rotation_angle(a.linear().transpose() * b.linear()); }

/// Rotation vectors up to a length, radians: a body-centred cubic lattice, the one that covers with the fewest points.
/// No turn within is farther from all of them than sqrt(5) / 4 of the spacing.
inline std::vector<Eigen::Vector3d> turn_lattice(double most, double spacing) {
  std::vector<Eigen::Vector3d> turns;
  const int reach = static_cast<int>(most / spacing) + 1;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      for (int k = -reach; k <= reach; ++k) {
        for (const double offset : {0.0, 0.5}) {
          const Eigen::Vector3d turn = spacing * (Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(offset));
          if (turn.norm() <= most) turns.push_back(turn);
        }
      }
    }
  }
  return turns;
}

}  // namespace holdfast
