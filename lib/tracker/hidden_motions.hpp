#pragma once

#include <vector>

#include "solve/normal_equations.hpp"

namespace holdfast {

/// An outline's equations without what it tells of these turns: rims of round things seem to tell of their turn where
/// they are cut into facets and pixels.
NormalEquations without_turns(NormalEquations outline, const std::vector<Twist>& turns);

}  // namespace holdfast
