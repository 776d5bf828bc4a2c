#include "solve/solver.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace holdfast {

Twist Conditioning::twist(const Twist& conditioned) const {
  Twist result;
  const Eigen::Vector3d w = conditioned.tail<3>();
  result.head<3>() = radius * conditioned.head<3>() - w.cross(p_camera_center);
  result.tail<3>() = w;
  return result;
}

Twist Conditioning::conditioned(const Twist& twist) const {
  Twist result;
  const Eigen::Vector3d w = twist.tail<3>();
  result.head<3>() = (twist.head<3>() + w.cross(p_camera_center)) / radius;
  result.tail<3>() = w;
  return result;
}

Matrix6 Conditioning::information(const Matrix6& A) const {
  // y1 = (v + w x c) / radius = (v - [c]x w) / radius, y2 = w.
  Eigen::Matrix3d cross;
  const Eigen::Vector3d& c = p_camera_center;
  cross << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0;
  Matrix6 M = Matrix6::Identity();
  M.topLeftCorner<3, 3>() /= radius;
  M.topRightCorner<3, 3>() = -cross / radius;
  return M.transpose() * A * M;
}

Solution solve(const ConstraintSums& sums, const Conditioning& conditioning, double damping) {
  Solution solution;
  if (sums.rows < 6) return solution;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(sums.A, Eigen::EigenvaluesOnly);
  solution.smallest_eigenvalue = eigen.eigenvalues()(0);
  // Sums of floats are good to 1e-7, but what is expected of a motion that does not show may count far less, and is all
  // that is known of it.
  if (!(solution.smallest_eigenvalue > 1e-12 * eigen.eigenvalues()(5))) return solution;
  const Matrix6 damped = sums.A + damping * sums.A.trace() / 6.0 * Matrix6::Identity();
  solution.conditioned = damped.ldlt().solve(sums.h);
  if (!solution.conditioned.allFinite()) return solution;
  solution.twist = conditioning.twist(solution.conditioned);
  solution.solved = true;
  return solution;
}

}  // namespace holdfast
