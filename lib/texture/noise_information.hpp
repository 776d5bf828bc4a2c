#pragma once

#include <span>

#include "holdfast/camera.hpp"
#include "solve/normal_equations.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// What the rows would say of the pose if the gradients that they are made of were nothing but errors: of noise, up to
/// a factor which depends on the blur alone, and of their direction (equation 12d of docs/math.md). `tile_sums` as
/// FlowConstraints has them; `camera` of their level; `noise_square` what the rows are off by, squared.
Matrix6 noise_information(std::span<const float> tile_sums, const kernel::hf_rect& tiles, const Camera& camera,
                          const Conditioning& conditioning, double noise_square, int channels = HF_CHANNELS);

/// Takes from a step, conditioned, what the rows do not show: along it A is no more than noise makes of itself. A step
/// y becomes `observable` y, A becomes observable^T A observable, h observable^T h; what is left of A has nothing in
/// common with what is taken. The identity where everything shows.
struct UnobservableMotions {
  Matrix6 observable = Matrix6::Identity();
  int count = 0;                      ///< of the motions that were taken
  Matrix6 motions = Matrix6::Zero();  ///< these, the first columns

  /// Of what was known of all motions, what is known of those that show.
  Matrix6 of(const Matrix6& A) const { return observable.transpose() * A * observable; }
};
UnobservableMotions unobservable_motions(const Matrix6& A, const Matrix6& noise);

}  // namespace holdfast
