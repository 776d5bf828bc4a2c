#include "texture/texture_modality.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Looser tests on coarse levels, where the motion is not known yet: radians, share of the larger gradient, share of
/// the neighbourhood.
constexpr double kCoarseAngle = 0.8, kCoarseDifference = 0.8, kCoarseVote = 0.5;
/// Degrees of freedom of the Student-t residual model.
constexpr double kFreedom = 4;
constexpr double kLeastScale = 0.004, kMostScale = 0.1;
/// Intensity of the frame that is never reached: no row is clipped.
constexpr double kNeverSaturated = 2;
/// Rows of three channels that count as one observation: neighbours share the blur, the texture's and the codec's
/// errors.
constexpr double kRowsPerObservation = 40;
/// Share of gradient pixels that passes the tests by chance, and share of those that show the texture truly.
constexpr double kChanceRatio = 0.06, kTrueRatio = 0.85;
/// Correlation of pixels that passed the tests by chance, at most in nine of ten frames: their gradients are alike.
constexpr double kChanceCorrelation = 0.4;

}  // namespace

double TextureModality::rows_per_observation() const {
  return grey_ ? kRowsPerObservation / HF_CHANNELS : kRowsPerObservation;
}

double texture_reliability(double inlier_ratio, double correlation) {
  const double visible = std::clamp((inlier_ratio - kChanceRatio) / (kTrueRatio - kChanceRatio), 0.0, 1.0);
  const double truly = inlier_ratio > 0 ? visible * kTrueRatio / std::min(inlier_ratio, kTrueRatio) : 0;
  const double alike = std::max(0.0, (correlation - kChanceCorrelation) / (1 - kChanceCorrelation));
  return truly * alike * alike;
}

TextureModality::TextureModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                                 const Tuning& tuning)
    : levels_(levels),
      extent_(extent),
      tuning_(tuning),
      constraints_(device, levels),
      photometry_(device, levels, tuning.photometric) {
  tiles_.reserve(static_cast<std::size_t>(levels[0].tiles_x()) * static_cast<std::size_t>(levels[0].tiles_y()));
  block_strip_.reserve(static_cast<std::size_t>(levels[0].tiles_x()));
}

void TextureModality::start(const TextureState& state) {
  photometry_.forget_cells();
  photometry_.set_object_pair(state.light);
}

OcclusionOptions TextureModality::tests_of(const TextureRequest& request) const {
  OcclusionOptions tests = tuning_.occlusion;
  if (request.level > request.finest) {
    tests.angle_maximum = std::max(tests.angle_maximum, kCoarseAngle);
    tests.difference_relative = std::max(tests.difference_relative, kCoarseDifference);
    tests.vote_share = std::min(tests.vote_share, kCoarseVote);
  }
  return tests;
}

kernel::hf_constraints TextureModality::constraint_options(const TextureRequest& request,
                                                           const Conditioning& conditioning,
                                                           const TextureState& state) const {
  const auto l = static_cast<std::size_t>(request.level);
  kernel::hf_constraints k{};
  for (int i = 0; i < 3; ++i) k.center[i] = static_cast<float>(conditioning.p_camera_center(i));
  k.radius = static_cast<float>(conditioning.radius);
  set_intrinsics(k, levels_[l].camera);
  k.every = request.row_stride;
  k.block_vote = tuning_.occlusion.block_vote ? 1 : 0;
  k.vote_radius = std::max(1, HF_VOTE_RADIUS - request.level);
  k.vote_share = static_cast<float>(tests_of(request).vote_share);
  k.robust = tuning_.robust_weights ? 1 : 0;
  k.inverse_scale2 = static_cast<float>(1.0 / (state.residual_scale[l] * state.residual_scale[l]));
  k.freedom = static_cast<float>(kFreedom);
  k.redundancy = tuning_.occlusion.redundancy ? 1 : 0;
  k.redundancy_cosine2 = static_cast<float>(tuning_.occlusion.redundancy_cosine * tuning_.occlusion.redundancy_cosine);
  k.gradient_minimum2 = static_cast<float>(tuning_.occlusion.gradient_minimum * tuning_.occlusion.gradient_minimum);
  k.saturated = static_cast<float>(tuning_.paper() ? kNeverSaturated : kSaturated);
  // A coarse level's cells are too large for their middles to stand for them: what is eliminated could exceed A.
  k.elimination = request.level == request.finest && photometry_.eliminates() ? 1 : 0;
  return k;
}

void TextureModality::enqueue(const ViewTemplate& view, const DeviceImage& image, const Pose& D,
                              const TextureRequest& request, const TextureState& state) {
  const auto l = static_cast<std::size_t>(request.level);
  request_ = request;
  grey_ = image.grey();
  const Conditioning conditioning = this->conditioning(view);
  photometry_.enqueue_upload(request.level, view.planes(request.level).tiles);
  auto warp = make_warp(levels_[l].camera, D, conditioning.p_camera_center, image.valid(request.level));
  warp.every = request.row_stride;
  last_ = constraint_options(request, conditioning, state);
  constraints_.enqueue(view, image, request.level, warp, make_tests(tests_of(request)), last_,
                       photometry_.buffer(request.level));
}

TextureTerms TextureModality::read(const ViewTemplate& view, TextureState& state) {
  const TextureRequest& request = request_;
  const auto l = static_cast<std::size_t>(request.level);
  TextureTerms terms;
  terms.row_stride = request.row_stride;
  ConstraintSums& sums = terms.sums;
  sums = constraints_.read();
  sums.A_rows = sums.A;
  if (last_.elimination) photometry_.eliminate(constraints_, last_, sums);
  sums.scale = state.residual_scale[l];
  terms.correlation = Photometry::correlation(constraints_);
  terms.reliability = tuning_.reliability ? texture_reliability(terms.inlier_ratio(), terms.correlation) : 1;
  if (request.learn) {
    photometry_.update(request.level, constraints_);
    state.light = photometry_.object_pair();
    if (tuning_.robust_weights && sums.rows > 0) {
      state.residual_scale[l] = std::clamp(std::sqrt(sums.weighted_square / sums.rows), kLeastScale, kMostScale);
    }
  }
  if (sums.rows < 6) return terms;
  if (request.unobservable) {
    remove_unobservable(view, request.level, terms);
  } else {
    set_equations(view, terms);
  }
  return terms;
}

void TextureModality::set_equations(const ViewTemplate& view, TextureTerms& terms) const {
  const double factor =
      terms.reliability / std::max(1e-12, rows_per_observation() * terms.sums.weighted_square / terms.sums.rows);
  const UnobservableMotions& hidden = terms.unobservable;
  const Twist h = hidden.observable.transpose() * terms.sums.h;
  terms.equations =
      NormalEquations::from_camera_axes(factor * hidden.of(terms.sums.A), factor * h, view.T_camera_object());
}

void TextureModality::remove_unobservable(const ViewTemplate& view, int level, TextureTerms& terms) {
  const ConstraintSums& sums = terms.sums;
  if (sums.rows < 6) return;
  // Away from where it fits more is left over than noise.
  const double left_over = sums.weighted_square / std::max(1.0, sums.weight);
  const double noise_square = std::min(left_over, sums.scale * sums.scale);
  // With light eliminated by cells' middles A may be less than nothing along motions that the rows do show.
  terms.unobservable =
      unobservable_motions(sums.A_rows, noise_information(constraints_.tile_sums(), constraints_.tiles(),
                                                          levels_[static_cast<std::size_t>(level)].camera,
                                                          conditioning(view), noise_square, grey_ ? 1 : HF_CHANNELS));
  set_equations(view, terms);
}

Matrix6 TextureModality::covariance(const ViewTemplate& view, const TextureTerms& terms, const Twist& last_step_camera,
                                    const Matrix6& others) {
  const Matrix6 B = to_camera_axes(view.T_camera_object());
  const Matrix6 others_camera = B * others * B.transpose();
  const ConstraintSums& sums = terms.sums;
  const auto posterior = [&](const Matrix6& A, const Matrix6& S, double curvature) {
    const Eigen::LDLT<Matrix6> factors(Matrix6(curvature * A + others_camera));
    const Matrix6 half = factors.solve(Matrix6(S + others_camera));
    const Matrix6 covariance = factors.solve(Matrix6(half.transpose()));
    return Matrix6(B.transpose() * (0.5 * (covariance + covariance.transpose())) * B);
  };
  if (sums.rows < 6 || terms.reliability <= 0) return posterior(Matrix6::Zero(), Matrix6::Zero(), 1);
  tile_equations(constraints_.tile_sums(), constraints_.tiles(), tiles_);
  if (last_.elimination) photometry_.eliminate(constraints_, last_, sums, tiles_);
  Matrix6 A = sums.A;
  if (terms.unobservable.count > 0) {
    const Matrix6& observable = terms.unobservable.observable;
    A = terms.unobservable.of(A);
    for (TileEquations& tile : tiles_) {
      tile.A = terms.unobservable.of(tile.A);
      tile.h = (observable.transpose() * tile.h).eval();
      tile.to_dark = (observable.transpose() * tile.to_dark).eval();
    }
  }
  const double unit = std::max(1e-12, rows_per_observation() * sums.weighted_square / sums.rows) / terms.reliability;
  const double curvature =
      tuning_.robust_weights ? robust_curvature(sums.weight / std::max(1.0, sums.rows), kFreedom) : 1;
  const Matrix6 S =
      score_covariance(tiles_, constraints_.tiles().width, last_step_camera, A + unit * others_camera, block_strip_);
  return posterior(A / unit, S / (unit * unit), curvature);
}

}  // namespace holdfast
