#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace holdfast::evaluation {

/// Exact distances to the nearest of a fixed set of points (a k-d tree).
class NearestPoint {
 public:
  /// At least one point.
  explicit NearestPoint(std::vector<Eigen::Vector3d> points);

  /// Distance from `query` to the nearest point, in the points' unit.
  double distance(const Eigen::Vector3d& query) const;

 private:
  void build(std::size_t begin, std::size_t end);
  void search(std::size_t begin, std::size_t end, const Eigen::Vector3d& query, double& best_squared) const;

  std::vector<Eigen::Vector3d> points_;  // of each range the middle one splits the rest along axes_
  std::vector<int> axes_;                // one a point
};

}  // namespace holdfast::evaluation
