#include "base/corner_motion.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Share of the centre's depth that corners are at least away: of a long object seen from near by, the cube reaches
/// behind the camera though no surface does.
constexpr double kNearest = 0.5;

}  // namespace

double corner_motion(const Extent& extent, const Camera& camera, const Pose& T_a, const Pose& T_b) {
  const double z_a = (T_a * extent.p_object_center).z(), z_b = (T_b * extent.p_object_center).z();
  if (z_a <= 0 || z_b <= 0) return 1e9;
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const Eigen::Vector3d p_object = extent.p_object_center + offset * (extent.radius / std::sqrt(3.0));
    Eigen::Vector3d a = T_a * p_object, b = T_b * p_object;
    a.z() = std::max(a.z(), kNearest * z_a);
    b.z() = std::max(b.z(), kNearest * z_b);
    largest = std::max(largest, (camera.project(a) - camera.project(b)).norm());
  }
  return largest;
}

}  // namespace holdfast
