#pragma once

#include "flow_constraints.hpp"
#include "solver.hpp"

namespace holdfast {

/// Covariance of a least-squares pose from how much its tiles disagree (equation 12 of docs/math.md). Rows are not
/// independent: neighbours share the blur, and errors of model, texture and sampling are alike over many pixels. Tiles
/// are nearly independent, so their scores say how uncertain the sum is, whatever the rows have in common.
///
/// What an estimate of n tiles' scores h_t needs: sum of (h_t - A_t y)(h_t - A_t y)^T, with what their systematic
/// displacements add. `y` is the step solved for, in the sums' conditioned coordinates.
Matrix6 score_covariance(const FlowConstraints& constraints, const Twist& conditioned_step,
                         const Conditioning& conditioning, double fx, double fy);

/// Conditioned covariance A^-1 S A^-1 of the pose, the scores' covariance S, `prior` an independent prior's information
/// on every conditioned unknown (above 0).
Matrix6 pose_covariance(const Matrix6& A, const Matrix6& S, double prior_weight, double prior_deviation);

/// Largest standard deviation, in any conditioned direction, that rows and prior leave together when `prior_weight` is
/// the prior's information in units of A's.
double posterior_deviation(const Matrix6& A, double prior_weight, double prior_deviation);

}  // namespace holdfast
