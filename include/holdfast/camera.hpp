#pragma once

#include <Eigen/Core>
#include <array>

#include "holdfast/export.hpp"

namespace holdfast {

/// How a lens bends what a pinhole would show.
enum class LensModel {
  polynomial,  ///< OpenCV's rational model: k1 k2 p1 p2 k3 k4 k5 k6
  fisheye,     ///< Kannala and Brandt's, OpenCV's cv::fisheye, ROS's and Kalibr's `equidistant`: k1 k2 k3 k4
};

/// Pinhole camera with optional lens distortion. Axes as OpenCV (x right, y down, z forward); pixel centres at
/// integers, so the image spans [-0.5, width - 0.5].
struct HOLDFAST_EXPORT Camera {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  double fx = 0;   ///< focal length, pixels
  double fy = 0;   ///< focal length, pixels
  double cx = 0;   ///< principal point, pixels
  double cy = 0;   ///< principal point, pixels
  /// Of the lens model, the rest zero. All zero: no distortion of a polynomial lens, an ideal fisheye's otherwise.
  std::array<double, 8> distortion{};
  LensModel lens = LensModel::polynomial;

  bool has_distortion() const;

  /// Pixel of a point in the camera frame (metres, z > 0), without lens distortion (equation 1 in docs/math.md).
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const;

  /// Pixel in the recorded (distorted) frame of a pixel of the ideal pinhole image (equation 4).
  Eigen::Vector2d distort(const Eigen::Vector2d& pixel) const;

  /// The same camera for frames of another size (both axes may scale differently).
  Camera rescaled(int new_width, int new_height) const;

  /// Throws Error(camera) when a size is not positive, or a parameter is not finite, or a focal length not positive.
  void validate() const;
};

}  // namespace holdfast
