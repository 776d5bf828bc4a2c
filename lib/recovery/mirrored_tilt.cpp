#include "recovery/mirrored_tilt.hpp"

#include <cmath>

#include "recovery/relocalizer.hpp"

namespace holdfast {
namespace {

/// Depth of what is seen about a plane, object radii, that shows which way it is tilted.
constexpr double kFlat = 0.04;

}  // namespace

std::optional<Pose> mirrored_tilt(const ViewTemplate& view, const Pose& T_camera_object, const Extent& extent) {
  const std::optional<Eigen::Vector3d> drawn = view.flat_normal(kFlat * extent.radius);
  if (!drawn) return {};
  const Eigen::Vector3d normal = T_camera_object.linear() * view.T_camera_object().linear().transpose() * *drawn;
  const Eigen::Vector3d to_camera = -(T_camera_object * extent.p_object_center).normalized();
  const Eigen::Vector3d axis = normal.cross(to_camera);
  const double turn = 2 * std::atan2(axis.norm(), normal.dot(to_camera));
  if (turn < kSamePose) return {};
  return turned_about_center(T_camera_object, extent, axis.normalized(), turn);
}

}  // namespace holdfast
