#include "judge/alignment.hpp"

#include <limits>

#include "solve/covariance.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {

double Alignment::turn_deviation() const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  return largest_deviation(Eigen::Matrix3d(covariance.bottomRightCorner<3, 3>()));
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

}  // namespace holdfast
