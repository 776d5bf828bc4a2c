#include "init/point_spread.hpp"

#include <Eigen/SVD>

namespace holdfast::app {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Points whose spread across their main direction is below this share of the spread along it lie on a line.
constexpr double kCollinear = 1e-3;

/// Spread along their main directions, metres, largest first.
Vector3d spreads(const std::vector<PointPair>& pairs) {
  const Vector3d middle = centroid(pairs);
  MatrixXd offsets(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    offsets.col(static_cast<Eigen::Index>(i)) = pairs[i].p_object - middle;
  }
  return Eigen::JacobiSVD<MatrixXd>(offsets).singularValues();
}

}  // namespace

Vector3d centroid(const std::vector<PointPair>& pairs) {
  Vector3d sum = Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    sum += pair.p_object;
  }
  return sum / static_cast<double>(pairs.size());
}

bool are_collinear(const std::vector<PointPair>& pairs) {
  const Vector3d spread = spreads(pairs);
  return !(spread[1] > kCollinear * spread[0]);
}

bool are_coplanar(const std::vector<PointPair>& pairs) {
  const Vector3d spread = spreads(pairs);
  return spread[2] < kCollinear * spread[0];
}

}  // namespace holdfast::app
