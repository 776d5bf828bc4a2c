#include "holdfast/camera.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast {

bool Camera::has_distortion() const {
  return lens == LensModel::fisheye ||
         std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p_camera) const {
  return {fx * p_camera.x() / p_camera.z() + cx, fy * p_camera.y() / p_camera.z() + cy};
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& pixel) const {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
  const double x = (pixel.x() - cx) / fx;
  const double y = (pixel.y() - cy) / fy;
  const double r2 = x * x + y * y;
  if (lens == LensModel::fisheye) {
    const double r = std::sqrt(r2), angle = std::atan(r), a2 = angle * angle;
    const double bent = angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (p1 + a2 * p2))));  // its third and fourth
    const double scale = r > 1e-12 ? bent / r : 1;
    return {fx * x * scale + cx, fy * y * scale + cy};
  }
  const double radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  const double x_distorted = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double y_distorted = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {fx * x_distorted + cx, fy * y_distorted + cy};
}

Camera Camera::rescaled(int new_width, int new_height) const {
  if (width <= 0 || height <= 0 || new_width <= 0 || new_height <= 0) {
    throw Error(ErrorCode::camera, "camera: cannot rescale from " + std::to_string(width) + "x" +
                                       std::to_string(height) + " to " + std::to_string(new_width) + "x" +
                                       std::to_string(new_height) + " pixels; both sizes must be positive");
  }
  const double scale_x = static_cast<double>(new_width) / width;
  const double scale_y = static_cast<double>(new_height) / height;
  Camera camera = *this;
  camera.width = new_width;
  camera.height = new_height;
  camera.fx = fx * scale_x;
  camera.fy = fy * scale_y;
  // Pixel centres are at integers, so the image's border, which scaling keeps, lies at -0.5.
  camera.cx = (cx + 0.5) * scale_x - 0.5;
  camera.cy = (cy + 0.5) * scale_y - 0.5;
  return camera;
}

void Camera::validate() const {
  if (width <= 0 || height <= 0) {
    throw Error(ErrorCode::camera, "camera: the image size is " + std::to_string(width) + "x" + std::to_string(height) +
                                       " pixels; give the width and height of the frames");
  }
  const bool finite = std::isfinite(fx) && std::isfinite(fy) && std::isfinite(cx) && std::isfinite(cy) &&
                      std::all_of(distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); });
  if (!finite) {
    throw Error(ErrorCode::camera,
                "camera: fx, fy, cx, cy or a distortion coefficient is NaN or infinite; check the "
                "calibration");
  }
  if (fx <= 0 || fy <= 0) {
    throw Error(ErrorCode::camera, "camera: the focal length is fx = " + std::to_string(fx) +
                                       ", fy = " + std::to_string(fy) + " pixels; both must be positive");
  }
}

}  // namespace holdfast
