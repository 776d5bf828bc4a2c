// What the pipeline learns from a frame, and what it tells of one.
#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"
#include "holdfast/error.hpp"
#include "imaging/exposure_estimator.hpp"
#include "solve/covariance.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {
namespace {

/// Of the size at which a level is left, the one at which it is taken again.
constexpr double kSmaller = 0.8;
/// Share of its bounding box that an object covers, as long as it is not known.
constexpr double kFilled = 0.6;
/// Weights of a new frame: in scores, in the usual inlier ratio, in shares of information.
constexpr double kScoreMemory = 0.2, kTextureMemory = 0.5, kRatioMemory = 0.02, kTrustMemory = 0.1,
                 kContourMemory = 0.1;
/// The same in the work of a frame, and how many times the usual work counts at most.
constexpr double kWorkMemory = 0.1, kMostWork = 2;
/// Pixels from where its motion leads, beyond which a pose is as doubtful as after a loss.
constexpr double kSurprise = 15;
/// A pose within this many radians and object radii of the last frame's may be the same object moving on.
constexpr double kSameTurn = 0.15, kSamePlace = 1.5, kNearTurn = 0.4;
/// Times the usual innovation, and least object radii and radians, that are a jump.
constexpr double kJump = 3, kLeastJump = 0.1;
/// Frames between learning the contour's colours where texture leads; misses after which they are of other
/// surroundings.
constexpr int kColorsEvery = 8, kMostContourMisses = 3;
/// Share of the lines whose edge is next to the contour where nothing hides it.
constexpr double kMostNear = 0.85;
/// How fast the contour's excess follows what each frame says, how much that is at most, and its bounds.
constexpr double kExcessMemory = 0.1, kMostSquare = 4, kLeastExcess = 1, kMostExcess = 30;
/// Appearances that a sweep of one frame covers, for how often a candidate must be seen again.
constexpr int kAppearancesAFrame = 32;
/// Frames in a row that must have shown the outline where it was not expected.
constexpr int kOutlineSeen = 3;
/// Share of the view's gradients that light may make to be drawn, and what of that it must be below to be drawn again.
constexpr double kMostLight = 0.2, kAgain = 0.7;
/// Light from one side that is not worth drawing.
constexpr double kLeastDirection = 0.02;
/// Pixels between the view drawn last and the pose, for light to be learned from it.
constexpr double kSameView = 2;
constexpr double kLow = 2;
/// How texels are averaged is measured in the first frames and then in one of so many once it is clear; of how many
/// measurements evidence is a mean, what it must be to change the choice, and to be clear; motion, pixels, below which
/// blur that is not known does not matter.
constexpr int kFirstMeasurements = 2, kTexelMemory = 8, kTexelPause = 64;
constexpr double kBetterEvidence = 0.01, kClearEvidence = 0.03, kTelling = 6;
/// Pixels with a gradient, fewer of which are no texture to go by.
constexpr double kFewGradients = 100;

/// Share of the lines across edges that must see one for a first pose to be taken at its word.
constexpr double kMostlyCoherent = 0.45;

double light_on(const LitPatch& patch, const DrawnLight& drawn) {
  return drawn.lit ? drawn.shading.of(patch.normal) : 1;
}

/// How much brighter the view is drawn than before; 0: nothing tells.
double brightening(std::span<const LitPatch> patches, const DrawnLight& before, const DrawnLight& now) {
  double brighter = 0, weight = 0;
  for (const LitPatch& patch : patches) {
    brighter += patch.weight * light_on(patch, now) / light_on(patch, before);
    weight += patch.weight;
  }
  return weight > 0 ? brighter / weight : 0;
}

}  // namespace

double Pipeline::frame_time(std::optional<double> time) {
  if (time ? frames_ > 0 : last_time_.has_value()) {
    throw Error(ErrorCode::invalid_argument,
                "some frames since reset() have a time and others none: give all of them one, or none");
  }
  if (!time) return ++frames_;
  if (!std::isfinite(*time) || (last_time_ && *time <= *last_time_)) {
    throw Error(ErrorCode::invalid_argument, "frame times must rise: " + std::to_string(*time) + " s comes after " +
                                                 std::to_string(last_time_.value_or(0)) +
                                                 " s; give frames in order, or none a time");
  }
  last_time_ = time;
  return *time;
}

void Pipeline::choose_finest_level() {
  int level = 0;
  double visible = state_.visible_pixels;
  if (visible <= 0) {
    const Rect object = view_.bounds(state_.motion.pose());
    visible = kFilled * object.width * object.height;
  }
  const auto many = [&](int at_level) {
    // Once coarser, the object must become clearly smaller to be seen in full again.
    return tuning_.most_pixels * (at_level < state_.finest ? kSmaller : 1.0) * (1 << (2 * at_level));
  };
  while (!tuning_.paper() && level + 1 < tuning_.levels && visible > many(level)) ++level;
  if (level == state_.finest) return;
  state_.gradient_pixels = 0;
  state_.usual.texture_score = 0;
  state_.finest = level;
}

void Pipeline::upload(const Rect& wanted, int margin) {
  const Rect region = image_.region(grown(wanted, margin));
  if (!uploaded_.empty() && region.x >= uploaded_.x && region.y >= uploaded_.y &&
      region.x + region.width <= uploaded_.x + uploaded_.width &&
      region.y + region.height <= uploaded_.y + uploaded_.height) {
    return;
  }
  const Stopwatch watch(aligner_.times().upload);
  (*upload_)(region);
  uploaded_ = region;
}

void Pipeline::see(const Pose& T_camera_object, bool exact, TrackingState& state) {
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return;
  upload(object, std::max(aligner_.contour().margin(), (filter_.radius() + 4) << state.finest));
  Alignment seen;
  seen.T_camera_object = T_camera_object;
  seen.imaging = state.imaging;
  if (state.textured) {
    image_.enqueue_blur(state.finest, coarser(grown(object, (filter_.radius() + 4) << state.finest), state.finest));
    if (aligner_.draw(T_camera_object, state.finest, 1, state, seen.imaging)) {
      const auto look = [&] {
        const TextureRequest request{state.finest, state.finest, 1, true, false};
        seen.texture = aligner_.texture().linearize(view_, image_, Pose::Identity(), request, seen.imaging.texture);
      };
      aligner_.texture().start_level(view_, state.finest);
      look();
      state.imaging = seen.imaging;
      learn_light(seen, state);
      seen.imaging = state.imaging;
      if (exact && aligner_.draw(T_camera_object, state.finest, 1, state, seen.imaging)) {
        aligner_.texture().start(seen.imaging.texture);
        aligner_.texture().start_level(view_, state.finest);
        look();
        look();
        seen.has_texture = true;
        state.imaging = seen.imaging;
      }
    }
  }
  if (tuning_.contour && !tuning_.paper()) {
    state.colors.clear();
    if (aligner_.contour().learn(T_camera_object, state.finest, state.colors)) {
      aligner_.contour().use_colors(state.colors);
    }
    if (exact && state.colors.known()) {
      seen.contour = aligner_.contour().linearize(T_camera_object, state.finest, kClosestSearch);
      seen.has_contour = seen.contour.found;
    }
    if (exact && tuning_.edges && aligner_.edges().has_edges()) {
      aligner_.edges().learn(T_camera_object, state.finest, state.edges);
      seen.edges = aligner_.edges().linearize(T_camera_object, state.finest, kClosestEdgeSearch, state.edges);
      seen.has_edges = seen.edges.found;
    }
  }
  if (exact) {
    state.seen = true;
    learn_usual(seen, true, state);
  }
}

bool Pipeline::start_as_given(const Pose& T_camera_object) {
  if (!tuning_.edges || !tuning_.contour || tuning_.paper() || !aligner_.edges().has_edges()) return false;
  const int level = std::min(state_.finest + 1, aligner_.contour().coarsest(T_camera_object, state_.finest));
  if (aligner_.edges().coherence(T_camera_object, level) < kMostlyCoherent) return false;
  state_.edges = aligner_.edges().no_memory();
  state_.edges.off_model = true;
  aligner_.edges().learn(T_camera_object, state_.finest, state_.edges);
  see(T_camera_object, true, state_);
  return true;
}

void Pipeline::learn_usual(const Alignment& alignment, bool first, TrackingState& state) const {
  UsualEvidence& usual = state.usual;
  if (alignment.has_texture) {
    const double score = alignment.texture.score(), ratio = alignment.texture.inlier_ratio();
    usual.texture_score += (usual.texture_score > 0 ? kTextureMemory : 1) * (score - usual.texture_score);
    // What is seen when nothing is in front: rises at once, falls slowly.
    usual.inlier_ratio = std::max(ratio, usual.inlier_ratio + kRatioMemory * (ratio - usual.inlier_ratio));
  }
  if (alignment.has_contour) {
    const double score = std::max(0.0, alignment.contour.score());
    const double off = score - usual.expected_contour_score();
    // Something in front of it must not become usual.
    const double square = std::min(off * off, kLow * kLow * usual.contour_variance);
    usual.contour_variance += kContourMemory * (square - usual.contour_variance);
    const double weight =
        usual.contour_score <= 0 ? 1.0 : std::max(kContourMemory, 1.0 / (2 + std::max(0, usual.held_frames)));
    usual.contour_score += weight * (score - usual.contour_score);
    usual.contour_information = alignment.contour.equations.A / (state.textured ? usual.contour_excess : 1.0);
  }
  const double outline = usual.contour_information.trace();
  if (alignment.has_edges) {
    const double score = std::max(0.0, alignment.edges.score());
    usual.edge_score += (usual.edge_score > 0 ? kContourMemory : 1) * (score - usual.edge_score);
    const double edges = alignment.edges.equations.A.trace();
    const double contour = alignment.has_contour ? alignment.contour.equations.A.trace() : 0;
    if (edges + contour > 0) {
      usual.edge_share += (usual.edge_share < 0 ? 1 : kTrustMemory) * (edges / (edges + contour) - usual.edge_share);
    }
  }
  double trust = 1;
  if (!alignment.has_texture) {
    trust = 0;
  } else if (alignment.has_contour) {
    const double texture = alignment.texture.equations.A.trace();
    trust = texture + outline > 0 ? texture / (texture + outline) : 1;
  }
  usual.texture_trust += (first ? 1 : kTrustMemory) * (trust - usual.texture_trust);
}

void Pipeline::learn_contour(const Alignment& alignment) {
  if (!tuning_.contour || tuning_.paper()) return;
  UsualEvidence& usual = state_.usual;
  const AcceptanceContext context = this->context(alignment, state_);
  const bool by_texture = is_held_by_texture(alignment, context);
  const bool texture_as_usual = by_texture && alignment.texture.inlier_ratio() > kUsualShare * usual.inlier_ratio;
  if (alignment.has_contour && by_texture && alignment.texture_covariance.trace() > 0) {
    // The contour's pull away from where texture leads, beside what both are said to be off by.
    const Matrix6 information = alignment.contour.equations.A / usual.contour_excess;
    const Twist pull = alignment.contour.equations.h / usual.contour_excess;
    const Matrix6 weak = 1e-9 * (1 + information.trace()) * Matrix6::Identity();
    const double square = pull.dot((alignment.texture_covariance + symmetric_inverse(information + weak)) * pull) / 6;
    const double factor = std::pow(std::clamp(square, 1 / kMostSquare, kMostSquare), kExcessMemory);
    usual.contour_excess = std::clamp(usual.contour_excess * factor, kLeastExcess, kMostExcess);
  }
  ++state_.frames_since_colors;
  bool learns = false;
  if (alignment.has_contour) {
    const ContourSums& sums = alignment.contour.sums;
    // Colours that fade as the light moves must be learned as long as their edges are where they should be.
    const bool fits =
        sums.near > kMostNear * sums.lines || alignment.contour.score() > kUsualShare * usual.expected_contour_score();
    state_.contour_misses = fits || !texture_as_usual ? 0 : state_.contour_misses + 1;
    learns = fits;
  } else {
    learns = texture_as_usual && state_.frames_since_colors >= kColorsEvery;
  }
  if (state_.contour_misses >= kMostContourMisses) {
    state_.colors.clear();
    usual.contour_score = 0;
    usual.contour_information.setZero();
    state_.contour_misses = 0;
    learns = true;
  }
  if (!learns) return;
  upload(view_.bounds(alignment.T_camera_object), aligner_.contour().margin());
  if (tuning_.edges && aligner_.edges().has_edges()) {
    aligner_.edges().learn(alignment.T_camera_object, state_.finest, state_.edges);
  }
  if (aligner_.contour().learn(alignment.T_camera_object, state_.finest, state_.colors)) {
    aligner_.contour().use_colors(state_.colors);
    state_.frames_since_colors = 0;
  }
}

void Pipeline::learn_light(const Alignment& alignment, TrackingState& state) {
  if (!tuning_.shading || !state.textured || view_.planes(state.finest).tiles.width == 0) return;
  if (aligner_.corner_motion(view_.T_camera_object(), alignment.T_camera_object) > kSameView) return;
  ImagingState& imaging = state.imaging;
  Photometry& photometry = aligner_.texture().photometry();
  photometry.set_object_pair(imaging.texture.light);
  const DrawnLight before{imaging.shading, imaging.lit};
  const std::span<const LitPatch> patches = lit_patches_.read(
      view_, aligner_.texture().samples(), state.finest, std::max(1, alignment.texture.row_stride), photometry, before);
  imaging.shading.learn(patches);
  imaging.lit = faceted_ || (imaging.shading.direction().norm() > kLeastDirection &&
                             lit_patches_.light_share() < kMostLight * (before.lit ? 1 : kAgain));
  const double factor = brightening(patches, before, {imaging.shading, imaging.lit});
  if (factor > 0) photometry.view_brightened(factor);
  imaging.texture.light = photometry.object_pair();
}

void Pipeline::learn_texels(const Alignment& alignment) {
  TexelState& texels = state_.imaging.texels;
  const bool clear = std::abs(texels.evidence) > kClearEvidence;
  const int pause = clear ? kTexelPause : texels.measured < kTexelMemory ? kTexelPause / 16 : kTexelPause / 4;
  if (texels.measured >= kFirstMeasurements && ++texels.frames < pause) return;
  texels.frames = 0;
  // Each way at its own best pose: the present one favours the present way.
  const auto left_over = [&](bool light) {
    TrackingState& tried = tried_;
    tried = state_;
    tried.imaging.texels.light = light;
    AlignmentPlan plan = fine_plan(state_.finest, state_);
    plan.expected = plan.measure = plan.contour = false;
    plan.redraws = 0;
    const ConstraintSums sums = aligner_.align(alignment.T_camera_object, plan, tried).texture.sums;
    return sums.rows >= 6 ? sums.weighted_square / std::max(1.0, sums.weight) : 0;
  };
  const double encoded = left_over(false), light = left_over(true);
  if (encoded <= 0 || light <= 0) return;
  texels.measured = std::min(texels.measured + 1, kTexelMemory);
  texels.evidence += (0.5 * std::log(encoded / light) - texels.evidence) / texels.measured;
  texels.light = texels.evidence > (texels.light ? -kBetterEvidence : kBetterEvidence);
}

void Pipeline::commit(const Alignment& alignment, double time) {
  const bool first = !state_.seen;
  const Pose T_predicted = prior_.T_camera_object;
  const bool was_moving = state_.motion.moving() && !state_.motion.lost();
  const bool usual = alignment.score > kUsualShare || state_.usual.held_frames == 0;
  state_.prediction_error = was_moving ? aligner_.corner_motion(T_predicted, alignment.T_camera_object) : 1e9;
  state_.imaging = alignment.imaging;
  if (alignment.coarse_score) {
    state_.usual.coarse_score += kScoreMemory * (*alignment.coarse_score - state_.usual.coarse_score);
  }
  if (alignment.has_texture) {
    const ConstraintSums& sums = alignment.texture.sums;
    state_.visible_pixels = sums.visible * alignment.texture.row_stride * (1 << (2 * state_.finest));
    state_.gradient_pixels = sums.gradient * alignment.texture.row_stride;
    state_.imaging.surviving_share = std::min(1.0, sums.usable / std::max(1.0, sums.visible));
    state_.left_unobservable = alignment.texture.unobservable.count > 0;
    const double weight = std::max(1.0 / (state_.usual.held_frames + 1), kRatioMemory);
    state_.usual.unobservable += weight * ((state_.left_unobservable ? 1 : 0) - state_.usual.unobservable);
    state_.usual.gain += kScoreMemory * (alignment.imaging.texture.light.gain[1] - state_.usual.gain);
    if (usual) learn_light(alignment, state_);
    const double motion = aligner_.corner_motion(state_.motion.pose(), alignment.T_camera_object);
    if (tuning_.motion_blur && state_.followed() && !tuning_.paper() &&
        exposure_is_due(state_.imaging.exposure, motion)) {
      measure_exposure(state_.imaging.exposure, [&](const ExposureState& exposure, bool across) {
        ImagingState tried = state_.imaging;
        tried.exposure = exposure;
        const Aligner::Fit fit = aligner_.fit(alignment.T_camera_object, state_, tried, across);
        return ExposureFit{fit.score, fit.residual};
      });
    }
    const bool sharp = motion < kTelling || state_.imaging.exposure.known();
    if (usual && sharp && state_.followed() && !tuning_.paper()) learn_texels(alignment);
    if (usual) relocalizer_.remember(alignment.T_camera_object);
  } else {
    state_.visible_pixels = alignment.contour.visible_pixels;
  }
  if (usual && searches_by_outline(state_)) outline_search_.remember(alignment.T_camera_object);
  learn_contour(alignment);
  learn_usual(alignment, first, state_);
  const double ms = aligner_.nominal_ms(), usual_ms = state_.usual.frame_ms;
  state_.usual.frame_ms += usual_ms > 0 ? kWorkMemory * (std::min(ms, kMostWork * usual_ms) - usual_ms) : ms;
  ++state_.usual.held_frames;
  state_.motion.update(alignment.T_camera_object, alignment.covariance, time);
  state_.seen = true;
  state_.suspected.reset();
  state_.probable_frames = 0;
  relocalizer_.end();
  outline_search_.end();
}

void Pipeline::miss(const Alignment& alignment, double time, FrameResult& result) {
  const bool again = state_.probable_frames > 0 && state_.suspected &&
                     goes_on(*state_.suspected, alignment.T_camera_object, kSameTurn);
  const AcceptanceContext context = this->context(alignment, state_);
  state_.probable_frames = is_probable(alignment, context) ? (again ? state_.probable_frames + 1 : 1) : 0;
  if (!state_.seen) state_.colors.clear();  // they are not the object's
  if (state_.probable_frames > 0 || is_promising(alignment, context)) {
    state_.suspected = alignment.T_camera_object;
  } else {
    state_.suspected.reset();
    result.T_camera_object = prior_.T_camera_object;
  }
  state_.motion.miss(time);
}

bool Pipeline::goes_on(const Pose& T_from, const Pose& T_to, double most_turn) const {
  const Eigen::Vector3d p_from = T_from * extent_.p_object_center, p_to = T_to * extent_.p_object_center;
  return rotation_angle(T_to.linear() * T_from.linear().transpose()) < most_turn &&
         (p_to - p_from).norm() < kSamePlace * extent_.radius;
}

bool Pipeline::seen_often_enough(const TrackingState& state) const {
  if (searches_by_outline(state)) return state.probable_frames >= kOutlineSeen;
  return state.probable_frames * kAppearancesAFrame >= relocalizer_.planned();
}

AcceptanceContext Pipeline::context(const Alignment& alignment, const TrackingState& state) const {
  AcceptanceContext result;
  const MotionFilter& motion = state.motion;
  const Pose& T = alignment.T_camera_object;
  result.lost_before = motion.lost();
  if (tuning_.paper()) result.least_ratio = 0.05;
  result.surprising = state.followed() && aligner_.corner_motion(prior_.T_camera_object, T) > kSurprise;
  result.near = goes_on(motion.pose(), T, kNearTurn) || goes_on(prior_.T_camera_object, T, kNearTurn);
  result.expected =
      result.near || (state.suspected && seen_often_enough(state) && goes_on(*state.suspected, T, kSameTurn));
  result.searched_everywhere = tuning_.recovery && motion.lost() && !tuning_.paper();
  const double farthest = std::max(kLeastJump, kJump * std::sqrt(motion.usual_innovation_squared()));
  result.jumps = motion.moving() && perturbation_between(prior_.T_camera_object, T, extent_).norm() > farthest;
  result.known_contour = state.colors.known();
  result.usual_inlier_ratio = state.usual.inlier_ratio;
  result.usual_outline = state.usual.outline();
  // A model of one colour has a texture too; before a frame was held nothing has told that it says nothing.
  const bool blank = state.usual.held_frames == 0 && alignment.has_texture &&
                     alignment.texture.sums.gradient * alignment.texture.row_stride < kFewGradients;
  result.texture_trust = state.textured && !blank ? state.usual.texture_trust : 0;
  result.unobservable_usually = state.usual.unobservable_usually();
  if (state.followed()) {
    const double moved = aligner_.corner_motion(motion.pose(), T);
    result.blur_pixels = state.imaging.exposure.share * moved;
    result.predicted_pixels = motion.moving() ? aligner_.corner_motion(motion.pose(), prior_.T_camera_object) : 0;
  }
  result.gain = alignment.imaging.texture.light.gain[1] / state.usual.gain;
  return result;
}

FrameResult Pipeline::report(const Alignment& alignment, const TrackingState& state) {
  const auto root_mean = [](double square, double weight) { return weight > 0 ? std::sqrt(square / weight) : 0; };
  const AcceptanceContext context = this->context(alignment, state);
  const Verdict verdict = judge(alignment, tuning_, context);
  FrameResult result;
  result.T_camera_object = alignment.T_camera_object;
  result.status = verdict.status;
  result.reason = verdict.reason;
  result.message = verdict.message;
  result.iterations = aligner_.solved_systems();
  result.texture.holds = is_held_by_texture(alignment, context);
  result.contour.holds = is_held_by_contour(alignment, context);
  last_by_contour_ = !result.texture.holds;
  if (alignment.has_texture) {
    const ConstraintSums& sums = alignment.texture.sums;
    TextureEvidence& texture = result.texture;
    texture.asked = true;
    texture.visible_pixels = static_cast<int>(sums.visible) * alignment.texture.row_stride << (2 * state.finest);
    texture.usable_pixels = static_cast<int>(sums.usable);
    texture.gradient_pixels = static_cast<int>(sums.gradient);
    texture.passed_pixels = static_cast<int>(sums.passed);
    texture.used_pixels = static_cast<int>(sums.used);
    texture.rows = static_cast<int>(sums.rows);
    texture.residual = root_mean(sums.weighted_square, sums.weight);
    texture.correlation = alignment.texture.correlation;
  }
  if (alignment.has_contour) {
    const ContourSums& sums = alignment.contour.sums;
    ContourEvidence& contour = result.contour;
    contour.asked = true;
    contour.visible_pixels = alignment.contour.visible_pixels;
    contour.lines = static_cast<int>(sums.lines);
    contour.telling_lines = static_cast<int>(sums.rows);
    contour.near_lines = static_cast<int>(sums.near);
    contour.agreement = sums.agreement;
    contour.residual = root_mean(sums.weighted_square, sums.weight);
  }
  if (alignment.has_edges) {
    const EdgeTerms& terms = alignment.edges;
    result.edges = {true, static_cast<int>(terms.lines), static_cast<int>(terms.near), terms.score(),
                    std::sqrt(terms.variance)};
  }
  if (alignment.covariance.trace() > 0) {
    const Matrix6 M = twist_of_perturbation(extent_);
    const Matrix6 covariance = M * alignment.covariance * M.transpose();
    result.covariance = 0.5 * (covariance + covariance.transpose());
    result.information = symmetric_inverse(result.covariance);
  }
  return result;
}

}  // namespace holdfast
