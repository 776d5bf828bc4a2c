#include "support/evaluated.hpp"

#include <Eigen/Geometry>

namespace holdfast::test {

Pose moved(const Pose& pose, double x_mm, double y_mm, double z_mm, double degrees_about_z) {
  Pose out = pose;
  out.pretranslate(Eigen::Vector3d(x_mm, y_mm, z_mm) * 1e-3);
  out.linear() =
      Eigen::AngleAxisd(evaluation::to_radians(degrees_about_z), Eigen::Vector3d::UnitZ()).toRotationMatrix() *
      out.linear();
  return out;
}

}  // namespace holdfast::test
