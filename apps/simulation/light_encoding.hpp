#pragma once

namespace holdfast::simulation {

/// Linear light of an encoded (sRGB) value, both in [0, 1].
double linear_from_encoded(double value);
/// Encoded (sRGB) value of linear light, both in [0, 1].
double encoded_from_linear(double value);

}  // namespace holdfast::simulation
