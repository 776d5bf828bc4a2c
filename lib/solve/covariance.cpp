#include "solve/covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

template <typename Matrix>
double largest_deviation_of(const Matrix& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(covariance.rows() - 1)));
}

}  // namespace

Matrix6 symmetric_inverse(const Matrix6& positive) {
  const Matrix6 result = positive.ldlt().solve(Matrix6::Identity());
  return 0.5 * (result + result.transpose());
}

double largest_deviation(const Matrix6& covariance) { return largest_deviation_of(covariance); }
double largest_deviation(const Eigen::Matrix3d& covariance) { return largest_deviation_of(covariance); }

}  // namespace holdfast
