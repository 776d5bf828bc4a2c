#include "solve/conditioning.hpp"

namespace holdfast {

Twist Conditioning::twist(const Twist& conditioned) const {
  Twist result;
  const Eigen::Vector3d w = conditioned.tail<3>();
  result.head<3>() = radius * conditioned.head<3>() - w.cross(p_camera_center);
  result.tail<3>() = w;
  return result;
}

Twist Conditioning::conditioned(const Twist& twist) const {
  Twist result;
  const Eigen::Vector3d w = twist.tail<3>();
  result.head<3>() = (twist.head<3>() + w.cross(p_camera_center)) / radius;
  result.tail<3>() = w;
  return result;
}

}  // namespace holdfast
