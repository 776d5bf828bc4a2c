#include "init/point_refinement.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "init/point_residuals.hpp"
#include "init/point_spread.hpp"

namespace holdfast::app {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

double PointEstimate::rms(std::size_t count) const { return std::sqrt(squared_sum / static_cast<double>(count)); }

PointRefinement::PointRefinement(const std::vector<PointPair>& pairs, bool with_focal)
    : pairs_(pairs), parameters_(with_focal ? 7 : 6), p_center_(centroid(pairs)) {}

PointEstimate PointRefinement::minimize(const Pose& T_start, const Camera& camera) const {
  PointEstimate best{T_start, camera, squared_sum(T_start, camera)};
  double damping = 1e-3;
  for (int iteration = 0; iteration < 100 && std::isfinite(best.squared_sum) && damping < 1e12; ++iteration) {
    const MatrixXd jacobian = jacobian_at(best);
    const MatrixXd normal = jacobian.transpose() * jacobian;
    const VectorXd gradient = jacobian.transpose() * stacked_residuals(best.T_camera_object, best.camera);
    MatrixXd damped = normal;
    damped.diagonal() += damping * normal.diagonal();
    const VectorXd step = -damped.ldlt().solve(gradient);
    PointEstimate next = step.allFinite() ? moved(best, step) : best;
    next.squared_sum = squared_sum(next.T_camera_object, next.camera);
    if (next.squared_sum < best.squared_sum) {
      const bool converged = best.squared_sum - next.squared_sum < 1e-14 * best.squared_sum || step.norm() < 1e-12;
      best = next;
      damping *= 0.1;
      if (converged) {
        break;
      }
    } else {
      damping *= 10;
    }
  }
  return best;
}

double PointRefinement::pixel_sigma(const PointEstimate& estimate, double least) const {
  const auto freedom = static_cast<double>(2 * pairs_.size()) - static_cast<double>(parameters_);
  return std::max(least, std::sqrt(estimate.squared_sum / std::max(freedom, 1.0)));
}

VectorXd PointRefinement::sigmas_per_pixel(const PointEstimate& estimate) const {
  const MatrixXd jacobian = jacobian_at(estimate);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(jacobian.transpose() * jacobian);
  const VectorXd variances = eigen.eigenvalues().cwiseMax(1e-12).cwiseInverse();
  return (eigen.eigenvectors().cwiseAbs2() * variances).cwiseSqrt();
}

PointEstimate PointRefinement::moved(const PointEstimate& from, const VectorXd& step) const {
  const Vector3d center = from.T_camera_object * p_center_;
  Twist twist;
  twist << step.head<3>() * center.norm(), step.segment<3>(3);
  PointEstimate to = from;
  to.T_camera_object = renormalized(Eigen::Translation3d(center) * exp_se3(twist) * Eigen::Translation3d(-center) *
                                    from.T_camera_object);
  if (parameters_ == 7) {
    to.camera.fx = to.camera.fy = from.camera.fx * std::exp(step[6]);
  }
  return to;
}

VectorXd PointRefinement::stacked_residuals(const Pose& T_camera_object, const Camera& camera) const {
  const std::vector<Vector2d> residuals = point_residuals(pairs_, camera, T_camera_object);
  VectorXd stacked(2 * static_cast<Eigen::Index>(residuals.size()));
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    stacked.segment<2>(2 * static_cast<Eigen::Index>(i)) = residuals[i];
  }
  return stacked;
}

double PointRefinement::squared_sum(const Pose& T_camera_object, const Camera& camera) const {
  const double sum = stacked_residuals(T_camera_object, camera).squaredNorm();
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

MatrixXd PointRefinement::jacobian_at(const PointEstimate& estimate) const {
  constexpr double step = 1e-6;
  MatrixXd jacobian(2 * pairs_.size(), parameters_);
  for (Eigen::Index i = 0; i < parameters_; ++i) {
    const PointEstimate up = moved(estimate, step * VectorXd::Unit(parameters_, i));
    const PointEstimate down = moved(estimate, -step * VectorXd::Unit(parameters_, i));
    jacobian.col(i) =
        (stacked_residuals(up.T_camera_object, up.camera) - stacked_residuals(down.T_camera_object, down.camera)) /
        (2 * step);
  }
  return jacobian;
}

}  // namespace holdfast::app
