#include "solve/normal_equations.hpp"

#include "base/turns.hpp"

namespace holdfast {

Pose perturbed(const Pose& T_camera_object, const Twist& y, const Extent& extent) {
  Twist xi = y;
  xi.head<3>() *= extent.radius;
  const Pose motion = exp_se3(xi);
  return renormalized(anchored(T_camera_object.linear() * motion.linear(), extent.p_object_center,
                               T_camera_object * (extent.p_object_center + motion.translation())));
}

Twist perturbation_between(const Pose& T_from, const Pose& T_to, const Extent& extent) {
  Pose motion = Pose::Identity();
  motion.linear() = T_from.linear().transpose() * T_to.linear();
  motion.translation() =
      T_from.linear().transpose() * (T_to * extent.p_object_center - T_from * extent.p_object_center);
  Twist y = log_se3(motion);
  y.head<3>() /= extent.radius;
  return y;
}

Matrix6 twist_of_perturbation(const Extent& extent) {
  // The origin moves by v + w x (0 - c) = v + c x w.
  const Eigen::Vector3d& c = extent.p_object_center;
  Matrix6 M = Matrix6::Identity();
  M.topLeftCorner<3, 3>() *= extent.radius;
  M.topRightCorner<3, 3>() << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0;
  return M;
}

Matrix6 to_camera_axes(const Pose& T_camera_object) {
  Matrix6 B = Matrix6::Zero();
  B.topLeftCorner<3, 3>() = B.bottomRightCorner<3, 3>() = T_camera_object.linear();
  return B;
}

NormalEquations NormalEquations::from_camera_axes(const Matrix6& A_camera, const Twist& h_camera, const Pose& T_drawn) {
  const Matrix6 B = to_camera_axes(T_drawn);
  NormalEquations result;
  result.A = B.transpose() * A_camera * B;
  result.h = B.transpose() * h_camera;
  return result;
}

}  // namespace holdfast
