#pragma once

#include <span>
#include <vector>

#include "solve/solver.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// A tile's normal equations, conditioned as the sums are.
struct TileEquations {
  Matrix6 A = Matrix6::Zero();
  Twist h = Twist::Zero();
  /// What h gains where light was averaged as something else than the view's: that moves every edge to its darker side.
  Twist to_dark = Twist::Zero();
  bool informative = false;
};

/// Row by row of these tiles, with which the sums begin.
void tile_equations(std::span<const float> tile_sums, const kernel::hf_rect& tiles,
                    std::vector<TileEquations>& equations);

/// Covariance of the sum of the tiles' scores h - A y (equation 12 of docs/math.md), `y` the step solved for. Rows are
/// not independent: neighbours share the blur, and errors of model, texture and sampling are alike over many pixels. So
/// it comes from blocks of tiles, each by how far the others alone would miss it. `A` is all tiles' and the prior's.
/// `lens_variance`: that the view was drawn with, square pixels; the more, the less sure is how light was averaged.
/// `strip` is working memory.
Matrix6 score_covariance(std::span<const TileEquations> tiles, int columns, const Twist& conditioned_step,
                         const Matrix6& A, double lens_variance, std::vector<TileEquations>& strip);

/// By how much less the scores change with the pose than A says: rows that fit worse also weigh less. 1 where weights
/// do not depend on residuals, (freedom + 1) / (freedom + 3) with Student's weights on a scale that fits.
double robust_curvature(double mean_weight, double freedom);

/// Of a positive definite matrix, symmetric to the last digit: information from covariance and back.
Matrix6 symmetric_inverse(const Matrix6& positive);

/// Standard deviation in the direction in which a covariance is largest.
double largest_deviation(const Matrix6& covariance);
double largest_deviation(const Eigen::Matrix3d& covariance);

/// What is known of the pose besides its rows: `weight` is added to A (positive definite), `scores` is the covariance
/// that this adds to theirs.
struct Prior {
  Matrix6 weight, scores;
};

/// Conditioned covariance of the pose, S the scores' covariance; the prior is independent of the rows.
Matrix6 pose_covariance(const Matrix6& A, double curvature, const Matrix6& S, const Prior& prior);

/// Conditioned covariance that drawing adds to a pose: fixed point and 8 bits put a whole view a little beside where it
/// belongs, which no part of it shows. `focal_length` in pixels of the level that was drawn.
Matrix6 drawing_covariance(const Conditioning& conditioning, double focal_length);

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
  void interrupt() { followed_ = 0; }
  /// Covariance that this adds to a pose seen with this exposure, a share of the time between frames (equation 12a).
  Matrix6 within(double exposure) const;

 private:
  /// Object radii and radians, until it is known, and how many frames that is worth.
  static constexpr double kExpected = 0.05, kExpectedFrames = 0.02;
  static constexpr double kMemory = 50;  ///< frames

  /// A running mean of squares.
  struct MeanSquare {
    Matrix6 value;
    double weight;
    void add(const Matrix6& square);
  };
  MeanSquare smooth_, sudden_;  ///< of accelerations, and of what is not smooth in them, a frame
  Twist last_ = Twist::Zero(), before_last_ = Twist::Zero();
  int followed_;  ///< deviations in a row, up to 2
};

}  // namespace holdfast
