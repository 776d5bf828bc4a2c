#include "solve/uncertain_origin.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace holdfast {

double kept_weight(double square) {
  constexpr double kFreedom = 2;
  return std::min(1.0, (kFreedom + 6) / (kFreedom + square));
}

NormalEquations without_origin(const NormalEquations& relative, const Matrix6& known, Twist& shift) {
  Eigen::LDLT<Matrix6> factors(Matrix6(relative.A + known));
  shift = -factors.solve(relative.h);
  factors.compute(relative.A + kept_weight(shift.dot(known * shift)) * known);
  shift = -factors.solve(relative.h);
  NormalEquations result;
  result.A = relative.A - relative.A * factors.solve(relative.A);
  result.A = (0.5 * (result.A + result.A.transpose())).eval();
  result.h = relative.h + relative.A * shift;
  return result;
}

}  // namespace holdfast
