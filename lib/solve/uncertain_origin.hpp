#pragma once

#include "solve/normal_equations.hpp"

namespace holdfast {

/// Weight of a pose that was known before, whose squared normalized error is `square`.
/// Student's t of two degrees of freedom in six dimensions, at most 1, so that what is suddenly far off counts little
/// (equation 19a of docs/math.md).
double kept_weight(double square);

/// What equations about an origin tell where the origin itself is known with the information `known` only, weighed by
/// kept_weight(): the origin's shift is eliminated, and its best value returned in `shift` (equation 37).
NormalEquations without_origin(const NormalEquations& relative, const Matrix6& known, Twist& shift);

}  // namespace holdfast
