#pragma once

#include <span>

#include "flow_constraints.hpp"
#include "solver.hpp"

namespace holdfast {

/// Covariance of a least-squares pose from how much its tiles disagree (equation 12 of docs/math.md). Rows are not
/// independent: neighbours share the blur, and errors of model, texture and sampling are alike over many pixels. Blocks
/// of tiles are nearly independent, so their scores say how uncertain the sum is, whatever the rows have in common.
///
/// What an estimate of scores h_t needs: the sum over blocks of (h - A y)(h - A y)^T, and what single rows add. `y` is
/// the step solved for, in the sums' conditioned coordinates.
Matrix6 score_covariance(std::span<const float> tile_sums, const kernel::hf_rect& tiles, const Twist& conditioned_step);

/// Conditioned covariance A^-1 S A^-1 of the pose, the scores' covariance S, `prior` an independent prior's information
/// on every conditioned unknown (above 0).
Matrix6 pose_covariance(const Matrix6& A, const Matrix6& S, double prior_weight, double prior_deviation);

/// Largest standard deviation, in any conditioned direction, that rows and prior leave together when `prior_weight` is
/// the prior's information in units of A's.
double posterior_deviation(const Matrix6& A, double prior_weight, double prior_deviation);

/// How an object strays from constant velocity from frame to frame. While the shutter is open it may change its
/// velocity; then the middle of the blurred picture is not where the object was in the middle of the exposure.
class Restlessness {
 public:
  Restlessness() { clear(); }
  void clear();
  /// The object came to be so far from where constant velocity had put it.
  void add(const Twist& conditioned_deviation);
  /// It was lost meanwhile: the next deviation has none before it.
  void interrupt() { followed_ = false; }
  /// Covariance that this adds to a pose seen with this exposure, a share of the time between frames (equation 12a).
  Matrix6 within(double exposure) const;

 private:
  static constexpr double kExpected = 0.05;  ///< object radii and radians, until it is known
  static constexpr double kMemory = 50;      ///< frames
  Matrix6 smooth_, sudden_;                  ///< mean squares of accelerations, and of changes of them, a frame
  Twist last_ = Twist::Zero();
  double weight_;
  bool followed_;
};

}  // namespace holdfast
