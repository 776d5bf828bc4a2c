#include "corner_motion.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {

double corner_motion(const Extent& extent, const Camera& camera, const Pose& T_a, const Pose& T_b) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const Eigen::Vector3d p_object = extent.p_object_center + offset * (extent.radius / std::sqrt(3.0));
    const Eigen::Vector3d a = T_a * p_object, b = T_b * p_object;
    if (a.z() <= 0 || b.z() <= 0) return 1e9;
    largest = std::max(largest, (camera.project(a) - camera.project(b)).norm());
  }
  return largest;
}

}  // namespace holdfast
