#pragma once

#include <span>
#include <vector>

#include "holdfast/pose.hpp"
#include "solve/normal_equations.hpp"
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
/// `strip` is working memory.
Matrix6 score_covariance(std::span<const TileEquations> tiles, int columns, const Twist& conditioned_step,
                         const Matrix6& A, std::vector<TileEquations>& strip);

/// By how much less the scores change with the pose than A says: rows that fit worse also weigh less. 1 where weights
/// do not depend on residuals, (freedom + 1) / (freedom + 3) with Student's weights on a scale that fits.
double robust_curvature(double mean_weight, double freedom);

/// Conditioned covariance that drawing adds to a pose: fixed point and 8 bits put a whole view a little beside where it
/// belongs, which no part of it shows. `focal_length` in pixels of the level that was drawn.
Matrix6 drawing_covariance(const Conditioning& conditioning, double focal_length);

}  // namespace holdfast
