#include "evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace holdfast::evaluation {
namespace {

double quantile_of_sorted(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double position = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(position));
  const double fraction = position - static_cast<double>(below);
  // Not written as a blend of both: infinite neighbours would give NaN where the weight is zero.
  if (fraction == 0) {
    return sorted[below];
  }
  if (std::isinf(sorted[below + 1])) {
    return sorted[below + 1];
  }
  return sorted[below] + fraction * (sorted[below + 1] - sorted[below]);
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return quantile_of_sorted(values, q);
}

Spread spread(const std::vector<double>& values) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  return {quantile_of_sorted(sorted, 0.5), quantile_of_sorted(sorted, 0.95), quantile_of_sorted(sorted, 1.0)};
}

}  // namespace holdfast::evaluation
