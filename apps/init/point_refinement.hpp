#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

/// A pose and a camera, and how well they put points to their pixels.
struct PointEstimate {
  Pose T_camera_object = Pose::Identity();
  Camera camera;
  double squared_sum = std::numeric_limits<double>::infinity();  ///< of the residuals, square pixels
  double rms(std::size_t count) const;
};

/// Least squares over pose and, where asked, focal length. The pose is moved about the points' centre in the camera
/// frame, in units of its distance: translation and rotation then hardly mix, and all parameters are of one size.
class PointRefinement {
 public:
  /// The pairs must outlive it.
  PointRefinement(const std::vector<PointPair>& pairs, bool with_focal);

  /// Levenberg-Marquardt; the sum stays infinite where points are behind the camera.
  PointEstimate minimize(const Pose& T_start, const Camera& camera) const;

  /// Standard deviation of a pixel coordinate that the residuals speak of, at least `least`.
  double pixel_sigma(const PointEstimate& estimate, double least) const;

  /// Standard deviations for pixels of standard deviation 1: translation as a share of the distance (3), rotation in
  /// radians (3), log focal length.
  Eigen::VectorXd sigmas_per_pixel(const PointEstimate& estimate) const;

 private:
  PointEstimate moved(const PointEstimate& from, const Eigen::VectorXd& step) const;
  Eigen::VectorXd stacked_residuals(const Pose& T_camera_object, const Camera& camera) const;
  double squared_sum(const Pose& T_camera_object, const Camera& camera) const;
  Eigen::MatrixXd jacobian_at(const PointEstimate& estimate) const;

  const std::vector<PointPair>& pairs_;
  Eigen::Index parameters_;
  Eigen::Vector3d p_center_;  // of the points, object frame
};

}  // namespace holdfast::app
