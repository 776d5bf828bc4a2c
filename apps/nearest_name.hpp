#pragma once

#include <string>
#include <vector>

namespace holdfast::app {

/// The name that was probably meant: the one with the fewest letters added, left out, changed or swapped with their
/// neighbour, the first of equals. Empty where a third of the letters or more would have to change.
std::string nearest_name(const std::string& given, const std::vector<std::string>& names);

}  // namespace holdfast::app
