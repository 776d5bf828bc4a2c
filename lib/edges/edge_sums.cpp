#include "edges/edge_sums.hpp"

#include <algorithm>

#include "texture/noise_information.hpp"

namespace holdfast {
namespace {

/// Lines that count as one observation: neighbours' errors are alike.
constexpr double kLinesPerObservation = 4;
/// Least variance of a row, square pixels.
constexpr double kLeastVariance = 0.01;
/// Variance of what all edges of a chain are off by together (print, wear or shadow that runs along it), over that of a
/// row. It is a parameter a chain, eliminated from the sums.
constexpr double kChainShift = 8;
/// Radians that an edge's direction is off: facets of what is round.
constexpr double kAstray = 0.1;

}  // namespace

Twist EdgeSums::row(const Eigen::Vector3d& p_camera, const Pose& D, const Eigen::Vector2d& direction,
                    const Camera& camera, const Conditioning& conditioning) {
  const Eigen::Vector3d p = D * p_camera;
  Eigen::Vector3d g(direction.x() * camera.fx / p.z(), direction.y() * camera.fy / p.z(), 0);
  g.z() = -(g.x() * p.x() + g.y() * p.y()) / p.z();
  g = (D.linear().transpose() * g).eval();
  Twist result;
  result << conditioning.radius * g, (p_camera - conditioning.p_camera_center).cross(g);
  return result;
}

void EdgeSums::add(const VisibleEdge& edge, const Pose& D, const Camera& camera, int chain, double weight,
                   double offset) {
  if (chain != chain_) {
    eliminate(A_, h_);
    shift_ = {};
    chain_ = chain;
  }
  const Twist across = row(edge.p_camera, D, edge.normal, camera, conditioning_);
  const Twist along = row(edge.p_camera, D, {-edge.normal.y(), edge.normal.x()}, camera, conditioning_);
  A_ += weight * across * across.transpose();
  h_ += weight * offset * across;
  astray_ += weight * kAstray * kAstray * along * along.transpose();
  weighted_square_ += weight * offset * offset;
  rows_ += weight;
  shift_.coupling += weight * across;
  shift_.weight += weight;
  shift_.offset += weight * offset;
}

void EdgeSums::eliminate(Matrix6& A, Twist& h) const {
  const double information = shift_.weight + kLinesPerObservation / kChainShift;
  A -= shift_.coupling * shift_.coupling.transpose() / information;
  h -= shift_.coupling * shift_.offset / information;
}

double EdgeSums::variance() const { return rows_ > 0 ? std::max(kLeastVariance, weighted_square_ / rows_) : 0; }

NormalEquations EdgeSums::equations(const Pose& T_lines) const {
  if (rows_ <= 0) return {};
  Matrix6 A = A_;
  Twist h = h_;
  eliminate(A, h);
  const double unit = kLinesPerObservation * variance();
  const UnobservableMotions hidden = unobservable_motions(A, astray_);
  return NormalEquations::from_camera_axes(hidden.of(A) / unit, hidden.observable.transpose() * h / unit, T_lines);
}

}  // namespace holdfast
