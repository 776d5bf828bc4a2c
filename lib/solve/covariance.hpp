#pragma once

#include "holdfast/pose.hpp"

namespace holdfast {

/// Of a positive definite matrix, symmetric to the last digit: information from covariance and back.
Matrix6 symmetric_inverse(const Matrix6& positive);

/// Standard deviation in the direction in which a covariance is largest.
double largest_deviation(const Matrix6& covariance);
double largest_deviation(const Eigen::Matrix3d& covariance);

}  // namespace holdfast
