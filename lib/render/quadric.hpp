#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace holdfast {

/// Area-weighted sum of squared distances, of surface and of texture (as metres on the surface), from faces' planes;
/// of points given by where they are (metres), where their texture is, 1 (Garland and Heckbert, 1998).
struct Quadric {
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  /// Share of Q's trace that holds a vertex where it was, for directions in which it may slide at no cost.
  static constexpr double kHeld = 1e-4;

  Matrix6 Q = Matrix6::Zero();
  double area = 0;

  void operator+=(const Quadric& other) {
    Q += other.Q;
    area += other.area;
  }
  double mean_square(const Vector6& x) const { return area > 0 ? std::max(0.0, x.dot(Q * x)) / area : 0; }

  /// The point of least distance near x, of those at this `height` along `normal` (metres; a zero normal: of all).
  Vector6 best_near(const Vector6& x, const Eigen::Vector3d& normal, double height) const {
    const double held = kHeld * Q.topLeftCorner<5, 5>().trace();
    if (!(held > 0)) return x;
    const Eigen::LDLT<Matrix5> A(Q.topLeftCorner<5, 5>() + held * Matrix5::Identity());
    Vector6 best = x;
    best.head<5>() = A.solve(held * x.head<5>() - Q.topRightCorner<5, 1>());
    Vector5 across = Vector5::Zero();
    across.head<3>() = normal;
    const Vector5 way = A.solve(across);
    if (way.dot(across) > 0) best.head<5>() += (height - normal.dot(best.head<3>())) / way.dot(across) * way;
    return best;
  }
};

}  // namespace holdfast
