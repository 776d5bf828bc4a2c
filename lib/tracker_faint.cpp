#include <algorithm>
#include <cmath>

#include "stopwatch.hpp"
#include "tracker_impl.hpp"

namespace holdfast {
namespace {

/// Share of the option's deviation below which texture is no longer faint.
constexpr double kClear = 0.5;
/// The same, above which its colours are known in case it vanishes, learnt in one of so many frames.
constexpr double kWatched = 0.25;
constexpr int kLearnEvery = 4;
/// Frames after which they are of other surroundings.
constexpr int kForgottenAfter = 30;
/// How far the object strays from its motion in a frame where nothing shows it, and where that motion is not known:
/// object radii and radians.
constexpr double kDrift = 0.01, kUnknownDrift = 0.05;
/// How far from where its motion leads an outline alone is not believed: of how far the object usually strays, and
/// object radii and radians.
constexpr double kJump = 5, kLeastJump = 0.05;
/// Share of its usual score that an outline alone needs, where texture was to be had: to be held on to, to be found, to
/// be learnt from.
constexpr double kHeldAlone = 0.7, kFoundAlone = 0.85, kLearntAlone = 0.9;
/// Least pixels inside an outline beside texture: the depth of smaller objects hardly shows in it.
constexpr int kLeastPixels = 1000;
/// How fast what the outline's covariance lacks follows what each frame says of it, how much that is at most, and
/// between which factors it stays.
constexpr double kExcessMemory = 0.1, kMostSquare = 4, kLeastExcess = 1, kMostExcess = 30;
/// Frames in a row in which texture is seen as usual and the outline is not, after which its colours are learnt anew.
constexpr int kMostMisses = 5;

}  // namespace

template <typename Frame>
bool Tracker::Impl::follow_faint(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope,
                                 bool search, Estimate& best, OutlineEstimate& outline) {
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
  if (!motion_.lost() && !course_.fresh()) {
    alone = fine_stage(hypotheses.poses[0], finest_, -1);
    if (fits_as_usual(alone)) {
      if (!known) return accept(alone);
      outline = outline_.estimate_nearby(alone.T_camera_object, finest_);
      add_outline_effort();
      if (!is_followed(outline)) return accept(alone);
      const Estimate both = with_outline(outline, [&] { return resumed(alone); });
      return accept(is_good(both) ? both : alone);
    }
  }
  if (known) {
    outline = outline_estimate(hypotheses);
  } else if (course_.visible_pixels <= 0) {
    outline = first_outline(hypotheses);
  }
  add_outline_effort();
  if (is_followed(outline)) {
    const int coarsest = std::max(finest_, std::min(finest_ + 1, scope.coarse_finest));
    const Estimate both = with_outline(outline, [&] { return fine_stage(outline.T_camera_object, coarsest, -1); });
    if (fits_as_usual(both)) return accept(both);
    // An outline may have look-alikes where texture has none.
    if (is_good(alone) && alone.score > both.score) return accept(alone);
    if (is_good(both)) return accept(both);
    // After a loss texture is looked for everywhere first: it alone may tell how the object is turned.
    if (!motion_.lost() && suffices(outline)) return true;
  }
  best = follow_fully(frame, hypotheses, scope, search);
  // Not enough to be held by, but a better guess than none.
  return is_followed(outline) && !is_good(best) && !is_promising(best);
}

Rect Tracker::Impl::outline_region(const Scope& scope) const {
  return united(scope.region, image_.region(grown(scope.wanted, outline_.margin())));
}

template <typename Stage>
Estimate Tracker::Impl::with_outline(const OutlineEstimate& outline, const Stage& stage) {
  outline_said_ = outline;
  const Estimate both = stage();
  outline_said_.reset();
  if (is_good(both)) compare_outline(both, outline);
  return both;
}

Estimate Tracker::Impl::resumed(const Estimate& estimate) {
  const Stopwatch watch(times_.solve);
  Pose D = renormalized(estimate.T_camera_object * view_.T_camera_object().inverse());
  Estimate result = iterate(finest_, D, options_.iterations);
  if (result.solved) measure_spread(result);
  return result;
}

double Tracker::Impl::stray(const Pose& T_camera_object) const {
  const Conditioning at_object{T_camera_object * p_object_center_, radius_};
  return at_object.conditioned(log_se3(T_camera_object * motion_.predicted().inverse())).norm();
}

bool Tracker::Impl::suffices(const OutlineEstimate& outline) const {
  if (outline.visible_pixels < kLeastPixels) return false;
  if (motion_.lost()) return outline.score >= kFoundAlone * expected_outline();
  const double farthest = std::max(kLeastJump, kJump * std::sqrt(course_.usual_stray_squared));
  const bool jumps = motion_.moving() && stray(outline.T_camera_object) > farthest;
  return outline.score >= kHeldAlone * expected_outline() && !jumps;
}

void Tracker::Impl::compare_outline(const Estimate& both, const OutlineEstimate& outline) {
  const Matrix6 information = outline.information / outline_excess_;
  const Twist pull =
      information * outline.conditioning.conditioned(log_se3(outline.T_camera_object * both.T_camera_object.inverse()));
  const double square = pull.dot((both.texture_covariance + symmetric_inverse(information)) * pull) / 6;
  const double factor = std::pow(std::clamp(square, 1 / kMostSquare, kMostSquare), kExcessMemory);
  outline_excess_ = std::clamp(outline_excess_ * factor, kLeastExcess, kMostExcess);
}

void Tracker::Impl::carry_spread(const Pose& T_to) {
  const Eigen::Matrix3d turn = T_to.linear() * T_spread_.linear().transpose();
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = turn;
  const double drift = motion_.moving() && !motion_.lost() ? kDrift : kUnknownDrift;
  spread_ = both * spread_ * both.transpose() + drift * drift * Matrix6::Identity();
  T_spread_ = T_to;
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
  if (spread_.trace() <= 0) return;  // no texture has told yet how it is turned
  if (outline.hidden_turn_count > 0) result.T_camera_object = without_hidden_turns(outline);
  carry_spread(result.T_camera_object);
  spread_ = symmetric_inverse(symmetric_inverse(spread_) + outline.information / outline_excess_);
  result.information = outline.conditioning.information(symmetric_inverse(spread_));
  if (result.status == Status::held && turn_deviation(spread_) > kSureTurn) {
    result.status = Status::lost;
    result.reason = "little texture in view, and the outline does not tell how it is turned";
  }
}

void Tracker::Impl::judge_texture(const Estimate& estimate) {
  if (!options_.outline) return;
  const double deviation = largest_deviation(estimate.texture_covariance) / options_.faint_deviation;
  const bool large = course_.visible_pixels >= kLeastPixels;
  course_.faint = deviation > (course_.faint ? kClear : 1) && large;
  spread_ = estimate.covariance;
  T_spread_ = estimate.T_camera_object;
  if (deviation < kWatched || !large) {
    if (++since_learnt_ > kForgottenAfter) outline_.clear();
    return;
  }
  const bool in_sight = estimate.used_share() > kUsualScore * course_.usual_share;
  if (last_outline_score_ >= 0) remember_outline_score();
  // What an occluder looks like is not to be learnt as the object's.
  bool as_usual = course_.faint ? last_outline_score_ > kUsualScore * expected_outline() : in_sight;
  if (course_.faint && outline_.colors_known()) {
    outline_misses_ = as_usual || !in_sight ? 0 : outline_misses_ + 1;
    if (outline_misses_ >= kMostMisses) outline_.clear();
  }
  if (!outline_.colors_known()) {
    usual_outline_ = 0;
    as_usual = in_sight;
    since_learnt_ = kLearnEvery;
  }
  if (!as_usual || (!course_.faint && ++since_learnt_ < kLearnEvery)) return;
  since_learnt_ = outline_misses_ = 0;
  outline_.learn(estimate.T_camera_object, finest_);
  add_outline_effort();
}

void Tracker::Impl::note_outline_of_textured(const FrameResult& result) {
  course_.visible_pixels = result.visible_pixels;
  remember_outline_score();
  if (last_outline_score_ > kLearntAlone * expected_outline()) outline_.learn(result.T_camera_object, finest_);
  add_outline_effort();
}

template bool Tracker::Impl::follow_faint(const ImageView& frame, const MotionModel::Hypotheses& hypotheses,
                                          const Scope& scope, bool search, Estimate& best, OutlineEstimate& outline);
template bool Tracker::Impl::follow_faint(const DeviceImageView& frame, const MotionModel::Hypotheses& hypotheses,
                                          const Scope& scope, bool search, Estimate& best, OutlineEstimate& outline);

}  // namespace holdfast
