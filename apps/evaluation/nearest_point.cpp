#include "evaluation/nearest_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace holdfast::evaluation {

NearestPoint::NearestPoint(std::vector<Eigen::Vector3d> points) : points_(std::move(points)), axes_(points_.size(), 0) {
  build(0, points_.size());
}

void NearestPoint::build(std::size_t begin, std::size_t end) {
  if (end - begin < 2) {
    return;
  }
  Eigen::Vector3d low = points_[begin];
  Eigen::Vector3d high = points_[begin];
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points_[i]);
    high = high.cwiseMax(points_[i]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [this](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[axis] < b[axis]; });
  axes_[middle] = axis;
  build(begin, middle);
  build(middle + 1, end);
}

double NearestPoint::distance(const Eigen::Vector3d& query) const {
  double best_squared = std::numeric_limits<double>::infinity();
  search(0, points_.size(), query, best_squared);
  return std::sqrt(best_squared);
}

void NearestPoint::search(std::size_t begin, std::size_t end, const Eigen::Vector3d& query,
                          double& best_squared) const {
  if (begin == end) {
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  best_squared = std::min(best_squared, (points_[middle] - query).squaredNorm());
  const int axis = axes_[middle];
  const double side = query[axis] - points_[middle][axis];
  if (side < 0) {
    search(begin, middle, query, best_squared);
    if (side * side < best_squared) {
      search(middle + 1, end, query, best_squared);
    }
  } else {
    search(middle + 1, end, query, best_squared);
    if (side * side < best_squared) {
      search(begin, middle, query, best_squared);
    }
  }
}

}  // namespace holdfast::evaluation
