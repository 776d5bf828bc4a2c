#pragma once

#include <Eigen/Core>
#include <vector>

#include "evaluation/nearest_point.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::evaluation {

/// Largest distance between two of the points, exact.
double diameter(const std::vector<Eigen::Vector3d>& points);

/// The points that ADD and ADD-S average over: the distinct vertices, as published. A mesh with fewer than 500 (a box
/// has eight corners, the surface between them would not count) is stood for by 2,000 points spread evenly over its
/// surface, the same ones every time.
std::vector<Eigen::Vector3d> points_of(const Mesh& mesh);

/// Distances between a model at two poses.
class ModelPoints {
 public:
  explicit ModelPoints(const Mesh& mesh);
  ModelPoints(std::vector<Eigen::Vector3d> points, double diameter);

  double diameter() const { return diameter_; }  ///< of the vertices, metres

  /// ADD: mean distance between the same point at both poses, metres (Hinterstoisser et al. 2012). Infinite for poses
  /// that are not finite.
  double add(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated) const;

  /// ADD-S: mean distance from each point at the true pose to the nearest one at the estimated pose, metres: for
  /// objects that look alike from several sides. Infinite for poses that are not finite.
  double add_s(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated) const;

 private:
  std::vector<Eigen::Vector3d> points_;
  double diameter_ = 0;
  NearestPoint nearest_;
};

/// Share of errors below `threshold`, 0 to 1. NaN for no errors.
double share_below(const std::vector<double>& errors, double threshold);

/// Area under the curve of accuracy over threshold, thresholds from 0 to `maximum`, as a share of the largest area
/// possible: the mean of max(0, 1 - error / maximum). PoseCNN's AUC is 100 of it with maximum = 0.1 m; OPT's is 20 of
/// it with maximum = 0.2 diameters. NaN for no errors.
double area_under_accuracy(const std::vector<double>& errors, double maximum);

}  // namespace holdfast::evaluation
