#pragma once

#include <algorithm>
#include <vector>

namespace holdfast::bench {

/// The mean of a timed run would take every interruption by other programs for work.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace holdfast::bench
