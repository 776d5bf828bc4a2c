#include "judge/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/covariance.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {

double Alignment::turn_deviation() const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  return largest_deviation(Eigen::Matrix3d(covariance.bottomRightCorner<3, 3>()));
}

double Alignment::place_deviation() const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  return largest_deviation(Eigen::Matrix3d(covariance.topLeftCorner<3, 3>()));
}

double Alignment::observable_turn_deviation() const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  const Matrix6 B = to_camera_axes(T_camera_object);
  const Matrix6& observable = texture.unobservable.observable;
  const Matrix6 seen = observable * B * covariance * B.transpose() * observable.transpose();
  return largest_deviation(Eigen::Matrix3d(seen.bottomRightCorner<3, 3>()));
}

double Alignment::deviation() const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  return largest_deviation(covariance);
}

double near_share(const Alignment& alignment) {
  return alignment.contour.sums.near / std::max(1.0, alignment.contour.sums.lines);
}

double contour_evidence(const Alignment& alignment, const UsualOutline& usual) {
  // Where edges are is what counts; colours fade when what is behind the object changes.
  return std::sqrt(near_share(alignment) * std::max(0.0, alignment.contour.score()) / usual.contour_score);
}

double edge_evidence(const Alignment& alignment, const UsualOutline& usual) {
  return std::max(0.0, alignment.edges.score()) / usual.edge_score;
}

double outline_score(const Alignment& alignment, const UsualOutline& usual) {
  const double contour = contour_evidence(alignment, usual), edges = edge_evidence(alignment, usual);
  if (!alignment.has_edges) return alignment.has_contour ? contour : 0;
  if (!alignment.has_contour) return edges;
  double share = usual.edge_share;
  if (share < 0) {
    const double of_edges = alignment.edges.equations.A.trace(), of_contour = alignment.contour.equations.A.trace();
    share = of_edges + of_contour > 0 ? of_edges / (of_edges + of_contour) : 0;
  }
  return share * edges + (1 - share) * contour;
}

}  // namespace holdfast
