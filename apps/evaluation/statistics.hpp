#pragma once

#include <vector>

namespace holdfast::evaluation {

/// The value below which the share `q` (0 to 1) of the values lies, linearly interpolated between neighbours (as
/// numpy.quantile does). NaN for no values.
double quantile(std::vector<double> values, double q);

/// What a column of errors is summed up by.
struct Spread {
  double median = 0;
  double p95 = 0;
  double maximum = 0;
};

/// All NaN for no values.
Spread spread(const std::vector<double>& values);

}  // namespace holdfast::evaluation
