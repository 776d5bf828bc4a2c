// What becomes known of the object once a frame, and what is told of the frame.
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
/// Weights of a new frame: in scores, in the usual inlier ratio, in the work of a frame; how many times the usual work
/// counts at most.
constexpr double kScoreMemory = 0.2, kRatioMemory = 0.02, kWorkMemory = 0.1, kMostWork = 2;
/// Pixels from where its motion leads, beyond which a pose is as doubtful as after a loss.
constexpr double kSurprise = 15;
/// A pose within this many radians and object radii of the last frame's may be the same object moving on.
constexpr double kSameTurn = 0.15, kSamePlace = 1.5, kNearTurn = 0.4;
/// Times the usual innovation, and least object radii and radians, that are a jump.
constexpr double kJump = 3, kLeastJump = 0.1;
/// Appearances that a sweep of one frame covers, for how often a candidate must be seen again.
constexpr int kAppearancesAFrame = 32;
/// Frames in a row that must have shown the outline where it was not expected.
constexpr int kOutlineSeen = 3;
/// Motion, pixels, below which blur that is not known does not matter.
constexpr double kBlurs = 6;

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
  state_.T_snapshot.reset();
  state_.finest = level;
}

void Pipeline::upload(const Rect& wanted, int margin) {
  const Rect region = image_.region(grown(wanted, margin));
  if (contains(uploaded_, region)) return;
  const Stopwatch watch(aligner_.times().upload);
  (*upload_)(region);
  uploaded_ = region;
}

double Pipeline::gain(const Alignment& alignment) const {
  return alignment.imaging.texture.light.gain[image_.grey() ? 0 : 1];
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
    state_.usual.gain += kScoreMemory * (gain(alignment) - state_.usual.gain);
    if (usual) learn_light(alignment, state_);
    const double motion = aligner_.corner_motion(state_.motion.pose(), alignment.T_camera_object);
    if (tuning_.motion_blur && state_.followed() && !tuning_.paper() &&
        exposure_is_due(state_.imaging.exposure, motion)) {
      measure_exposure(state_.imaging.exposure, [&](const ExposureState& exposure, bool across) {
        ImagingState tried = state_.imaging;
        tried.exposure = exposure;
        return aligner_.fit(alignment.T_camera_object, state_, tried, across);
      });
    }
    const bool sharp = motion < kBlurs || state_.imaging.exposure.known();
    if (usual && sharp && state_.followed() && !tuning_.paper()) learn_texels(alignment);
    if (usual) relocalizer_.remember(alignment.T_camera_object);
  } else {
    state_.visible_pixels = alignment.contour.visible_pixels;
  }
  if (usual && tuning_.contour && !tuning_.paper()) outline_search_.remember(alignment.T_camera_object);
  learn_contour(alignment);
  learn_usual(alignment, first, state_);
  leave_texture(alignment);
  learn_snapshot(alignment);
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
  if (is_probable(alignment, context)) {
    state_.probable_frames = again ? state_.probable_frames + 1 : 1;
  } else if (!again || !may_go_on(alignment, context)) {
    state_.probable_frames = 0;
  }
  if (!state_.seen) state_.colors.clear();  // they are not the object's
  if (state_.probable_frames > 0 || is_promising(alignment, context)) {
    state_.suspected = alignment.T_camera_object;
  } else {
    state_.suspected.reset();
    result.T_camera_object = prior_.T_camera_object;
    result.covariance = result.information = Matrix6::Zero();
  }
  state_.motion.miss(time);
}

bool Pipeline::goes_on(const Pose& T_from, const Pose& T_to, double most_turn) const {
  const Eigen::Vector3d p_from = T_from * extent_.p_object_center, p_to = T_to * extent_.p_object_center;
  return rotation_angle(T_to.linear() * T_from.linear().transpose()) < most_turn &&
         (p_to - p_from).norm() < kSamePlace * extent_.radius;
}

bool Pipeline::seen_often_enough(const TrackingState& state) const {
  if (outline_leads(state)) return state.probable_frames >= kOutlineSeen;
  return state.probable_frames * kAppearancesAFrame >= relocalizer_.planned();
}

AcceptanceContext Pipeline::context(const Alignment& alignment, const TrackingState& state) const {
  AcceptanceContext result;
  const MotionFilter& motion = state.motion;
  const Pose& T = alignment.T_camera_object;
  result.lost_before = motion.lost();
  if (tuning_.paper()) result.least_ratio = 0.05;
  // A first pose may be anywhere, as long as no frame has shown it right.
  result.surprising =
      state.seen ? state.followed() && aligner_.corner_motion(prior_.T_camera_object, T) > kSurprise : !tuning_.paper();
  result.near = goes_on(motion.pose(), T, kNearTurn) || goes_on(prior_.T_camera_object, T, kNearTurn);
  result.expected =
      result.near || (state.suspected && seen_often_enough(state) && goes_on(*state.suspected, T, kSameTurn));
  result.searched_everywhere = tuning_.recovery && motion.lost() && !tuning_.paper();
  const double farthest = std::max(kLeastJump, kJump * std::sqrt(motion.usual_innovation_squared()));
  result.jumps = motion.moving() && perturbation_between(prior_.T_camera_object, T, extent_).norm() > farthest;
  result.usual_inlier_ratio = state.usual.inlier_ratio;
  result.usual_outline = state.usual.outline();
  // A side in view may be blank; before a frame was held nothing has told that texture says nothing.
  const bool blank = state.usual.held_frames == 0 && alignment.has_texture &&
                     alignment.texture.sums.gradient * alignment.texture.row_stride < kFewGradients;
  result.first = !state.seen;
  result.without_outline = state.without_outline;
  result.sure_snapshot = state.sure_snapshot;
  result.print_missing = state.print_missing;
  result.texture_trust = state.textured && !blank ? state.usual.texture_trust : 0;
  result.unobservable_usually = state.usual.unobservable_usually();
  if (state.followed()) {
    const double moved = aligner_.corner_motion(motion.pose(), T);
    result.blur_pixels = state.imaging.exposure.share * moved;
    result.predicted_pixels = motion.moving() ? aligner_.corner_motion(motion.pose(), prior_.T_camera_object) : 0;
  }
  result.gain = gain(alignment) / state.usual.gain;
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
    contour.residual = (1 << state.finest) * root_mean(sums.weighted_square, sums.weight);
  }
  if (alignment.has_edges) {
    const EdgeTerms& terms = alignment.edges;
    result.edges = {true, static_cast<int>(terms.lines), static_cast<int>(terms.near), terms.score(),
                    (1 << state.finest) * std::sqrt(terms.variance)};
  }
  if (alignment.has_snapshot) {
    const TextureTerms& terms = alignment.snapshot;
    result.snapshot = {true, is_held_by_snapshot(alignment, context), static_cast<int>(terms.sums.gradient),
                       static_cast<int>(terms.sums.used), terms.correlation};
  }
  if (alignment.covariance.trace() > 0) {
    const Matrix6 M = twist_of_perturbation(extent_);
    // The outlines that a snapshot's pose comes from have this outline's errors: it is no second witness (covariance
    // intersection). What moves from frame to frame is known better.
    const double witnesses = alignment.has_snapshot ? 2 : 1;
    const Matrix6 covariance = witnesses * M * alignment.covariance * M.transpose();
    result.covariance = 0.5 * (covariance + covariance.transpose());
    result.information = symmetric_inverse(result.covariance);
  }
  return result;
}

}  // namespace holdfast
