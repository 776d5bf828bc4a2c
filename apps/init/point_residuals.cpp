#include "init/point_residuals.hpp"

#include <cmath>

namespace holdfast::app {

std::vector<Eigen::Vector2d> point_residuals(const std::vector<PointPair>& pairs, const Camera& camera,
                                             const Pose& T_camera_object) {
  std::vector<Eigen::Vector2d> residuals;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d p_camera = T_camera_object * pair.p_object;
    const bool before = p_camera.z() > 0;
    const Eigen::Vector2d pixel = before ? camera.project(p_camera) : Eigen::Vector2d::Constant(std::nan(""));
    residuals.push_back((before && camera.has_distortion() ? camera.distort(pixel) : pixel) - pair.pixel);
  }
  return residuals;
}

double root_mean_square(const std::vector<Eigen::Vector2d>& residuals) {
  double sum = 0;
  for (const Eigen::Vector2d& residual : residuals) {
    sum += residual.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

}  // namespace holdfast::app
