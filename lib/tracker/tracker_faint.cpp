#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Share of the option's deviation below which texture is no longer faint.
constexpr double kClear = 0.5;
/// The same, above which the outline's colours are known in case texture vanishes.
constexpr double kWatched = 0.25;
/// How far from where its motion leads an outline alone is not believed: of how far the object usually strays, and
/// object radii and radians.
constexpr double kJump = 5, kLeastJump = 0.05;
/// Share of its usual score that an outline alone needs, where texture was to be had: to be held on to, to be found, to
/// be learnt from.
constexpr double kHeldAlone = 0.7, kFoundAlone = 0.85, kLearntAlone = 0.9;
/// Least pixels inside an outline beside texture: the depth of smaller objects hardly shows in it.
constexpr int kLeastPixels = 1000;

}  // namespace

template <typename Frame>
bool Tracker::Impl::follow_faint(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope,
                                 bool search, const Estimate* searched, Estimate& best, OutlineEstimate& outline) {
  const auto accept = [&](const Estimate& estimate) {
    best = estimate;
    remember_score(best);
    if (options_.motion_blur && moved_) measure_exposure(best);
    return false;
  };
  const auto fits_as_usual = [&](const Estimate& estimate) {
    return is_good(estimate) && estimate.score > kUsualScore * look_.expected_score();
  };
  const bool known = outline_.colors_known();
  Estimate alone;
  if (!searched && !motion_.lost() && !course_.fresh()) {
    alone = fine_stage(hypotheses.poses[0], finest_, -1);
    if (fits_as_usual(alone)) return accept(known ? beside_outline(alone, true, outline) : alone);
  }
  if (known) {
    // Started turned, it would hardly come to where it is believed.
    MotionModel::Hypotheses straight = hypotheses;
    straight.count -= hypotheses.turned;
    outline = outline_estimate(straight);
  } else if (course_.visible_pixels <= 0) {
    outline = first_outline(hypotheses);
  }
  add_outline_effort();
  if (is_followed(outline)) {
    const int coarsest = std::max(finest_, std::min(finest_ + 1, scope.coarse_finest));
    const Estimate both = fine_stage(outline.T_camera_object, coarsest, -1, kAnyMotion, &outline);
    compare_outline(both, outline);
    if (fits_as_usual(both)) return accept(both);
    // An outline may have look-alikes where texture has none.
    if (is_good(alone) && alone.score > both.score) return accept(alone);
    if (is_good(both)) return accept(both);
    if (!motion_.lost() && suffices(outline)) return true;
  }
  best = searched ? *searched : follow_fully(frame, hypotheses, scope, search);
  // Not enough to be held by, but a better guess than none.
  return is_followed(outline) && !is_good(best) && !is_promising(best);
}

Estimate Tracker::Impl::beside_outline(const Estimate& alone, bool drawn, OutlineEstimate& outline) {
  outline = outline_.estimate_nearby(alone.T_camera_object, finest_);
  add_outline_effort();
  if (!is_followed(outline)) return alone;
  const Estimate both =
      drawn ? resumed(alone, outline) : fine_stage(alone.T_camera_object, finest_, -1, kAnyMotion, &outline);
  compare_outline(both, outline);
  return is_good(both) ? both : alone;
}

Rect Tracker::Impl::outline_region(const Scope& scope) const {
  return united(scope.region, image_.region(grown(scope.wanted, outline_.margin())));
}

Estimate Tracker::Impl::resumed(const Estimate& estimate, const OutlineEstimate& outline) {
  const Stopwatch watch(times_.solve);
  Pose D = renormalized(estimate.T_camera_object * view_.T_camera_object().inverse());
  Estimate result = iterate(finest_, D, options_.iterations, kAnyMotion, &outline);
  if (result.solved) measure_spread(result, &outline);
  return result;
}

bool Tracker::Impl::suffices(const OutlineEstimate& outline) const {
  if (outline.visible_pixels < kLeastPixels) return false;
  if (motion_.lost()) return outline.score >= kFoundAlone * outline_memory_.expected_score();
  return outline.score >= kHeldAlone * outline_memory_.expected_score() && !jumps(outline);
}

bool Tracker::Impl::jumps(const OutlineEstimate& outline) const {
  const double farthest = std::max(kLeastJump, kJump * std::sqrt(course_.usual_stray_squared));
  return motion_.moving() && stray(outline.T_camera_object) > farthest;
}

void Tracker::Impl::compare_outline(const Estimate& both, const OutlineEstimate& outline) {
  if (is_good(both)) outline_memory_.compare(outline, both.T_camera_object, both.texture_covariance);
}

Pose Tracker::Impl::without_hidden_turns(const OutlineEstimate& outline) const {
  const Pose T_expected = motion_.supposed(options_.predict_velocity);
  Twist motion = outline.conditioning.conditioned(log_se3(outline.T_camera_object * T_expected.inverse()));
  for (int i = 0; i < outline.hidden_turn_count; ++i) {
    const Twist turn = outline.hidden_turns.col(i);
    motion -= turn * turn.tail<3>().dot(motion.tail<3>());
  }
  return renormalized(exp_se3(outline.conditioning.twist(motion)) * T_expected);
}

void Tracker::Impl::report_outline_of_textured(const OutlineEstimate& outline, FrameResult& result) {
  report_outline(outline, result);
  if (!suffices(outline)) {
    result.status = Status::lost;
    result.reason = "little texture in view, and the outline is not surely found";
  }
  if (!spread_.known()) return;  // no texture has told yet how it is turned
  if (outline.hidden_turn_count > 0) result.T_camera_object = without_hidden_turns(outline);
  spread_.carry(result.T_camera_object, motion_.moving() && !motion_.lost());
  spread_.add(outline_memory_.trusted_information(outline));
  result.information = outline.conditioning.information(symmetric_inverse(spread_.covariance()));
  Matrix6 seen = Matrix6::Identity();
  for (int i = 0; course_.hides_usually() && i < outline.hidden_turn_count; ++i) {
    const Twist turn = outline.hidden_turns.col(i);
    seen.rightCols<3>() -= turn * turn.tail<3>().transpose();
  }
  if (result.status == Status::held && turn_deviation(seen * spread_.covariance() * seen.transpose()) > kSureTurn) {
    result.status = Status::lost;
    result.reason = "little texture in view, and the outline does not tell how it is turned";
  }
}

void Tracker::Impl::judge_texture(const Estimate& estimate) {
  if (!options_.outline) return;
  const double deviation = largest_deviation(estimate.texture_covariance) / options_.faint_deviation;
  const bool large = course_.visible_pixels >= kLeastPixels;
  course_.faint = deviation > (course_.faint ? kClear : 1) && large;
  spread_.set(estimate.T_camera_object, estimate.covariance);
  if (deviation < kWatched || !large) {
    if (outline_memory_.forgets()) outline_.clear();
    return;
  }
  const bool in_sight = estimate.used_share() > kUsualScore * course_.usual_share;
  outline_memory_.remember_score();
  if (course_.faint && outline_.colors_known() && outline_memory_.mistrusts(in_sight)) outline_.clear();
  if (!outline_memory_.learns(outline_.colors_known(), course_.faint, in_sight)) return;
  outline_.learn(estimate.T_camera_object, finest_);
  add_outline_effort();
}

void Tracker::Impl::note_outline_of_textured(const FrameResult& result) {
  course_.visible_pixels = result.visible_pixels;
  outline_memory_.remember_score();
  if (outline_memory_.last_score() > kLearntAlone * outline_memory_.expected_score()) {
    outline_.learn(result.T_camera_object, finest_);
  }
  add_outline_effort();
}

template bool Tracker::Impl::follow_faint(const ImageView& frame, const MotionModel::Hypotheses& hypotheses,
                                          const Scope& scope, bool search, const Estimate* searched, Estimate& best,
                                          OutlineEstimate& outline);
template bool Tracker::Impl::follow_faint(const DeviceImageView& frame, const MotionModel::Hypotheses& hypotheses,
                                          const Scope& scope, bool search, const Estimate* searched, Estimate& best,
                                          OutlineEstimate& outline);

}  // namespace holdfast
