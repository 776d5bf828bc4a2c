#include <algorithm>
#include <array>
#include <cmath>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Pixels that the finest level may correct a coarse answer by to be believed without the level between.
constexpr double kMostCorrection = 1.5;
/// Poses that move the object's corners by less than so many pixels are the same.
constexpr double kSamePixels = 0.5;
/// Starts that are so many pixels apart are different.
constexpr double kApart = 4;
/// What a doubtful result is turned by to start again, radians.
constexpr double kChallengeTurn = 0.2;
/// What another way of drawing the view must score beside the present one to be believed.
constexpr double kClearlyBetter = 1.02;

}  // namespace

void Starts::add(const Estimate& start) {
  std::size_t place = count_++;
  for (; place > 0 && starts_[place - 1].score < start.score; --place) starts_[place] = starts_[place - 1];
  starts_[place] = start;
}

Tracker::Impl::Scope Tracker::Impl::scope(const MotionModel::Hypotheses& hypotheses, bool search) const {
  Scope scope;
  scope.finest = finest_;
  for (int i = 0; i < hypotheses.count; ++i) {
    scope.wanted = united(scope.wanted, view_.bounds(hypotheses.poses[static_cast<std::size_t>(i)]));
  }
  const Rect object = view_.bounds(hypotheses.poses[0]);
  const double side = std::sqrt(0.6 * object.width * object.height);
  while (scope.coarsest + 1 < options_.levels && side / (2 << scope.coarsest) >= kLeastSide) ++scope.coarsest;
  scope.coarsest = std::max(scope.coarsest, std::min(finest_ + 1, options_.levels - 1));
  // The first frame's coarse stage goes as far as it can: a view at full resolution then is drawn only once.
  const int next = scope.coarsest - 1;
  scope.coarse_finest = std::max(course_.fresh() ? std::min(next, finest_ + 1) : next, finest_);
  const int margin =
      ((filter_.radius() + 4) << scope.coarsest) + (search ? options_.search_radius : 0) + static_cast<int>(0.1 * side);
  if (search && options_.recovery && motion_.lost()) scope.wanted = {0, 0, camera_.width, camera_.height};
  scope.region = image_.region(grown(scope.wanted, margin));
  return scope;
}

Starts Tracker::Impl::coarse_starts(const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search) {
  Starts starts;
  if (scope.coarse()) {
    {
      const Stopwatch watch(times_.filter);
      for (int level = scope.coarse_finest; level <= scope.coarsest; ++level) {
        image_.enqueue_blur(level, coarser(scope.region, level));
      }
      if (search) search_.enqueue_gradients(image_, scope.coarsest);
      device_.impl().queue.flush();  // the device works while the first view is drawn
    }
    for (int i = 0; i < hypotheses.count; ++i) {
      const Pose& T_start = hypotheses.poses[static_cast<std::size_t>(i)];
      const Estimate estimate = coarse_stage(T_start, search, scope.coarsest, scope.coarse_finest);
      starts.add(estimate);
      // A first hypothesis that fits as well as usual needs no second.
      if (!motion_.lost() && estimate.solved && estimate.score > kUsualScore * look_.usual_score) break;
    }
  }
  // Where the coarse levels see too little, the plain prediction may still be the better start.
  for (int i = 0; i < hypotheses.count; ++i) {
    Estimate plain;
    plain.T_camera_object = hypotheses.poses[static_cast<std::size_t>(i)];
    starts.add(plain);
  }
  return starts;
}

Estimate Tracker::Impl::best_from(const Starts& starts, const MotionModel::Hypotheses& hypotheses, const Scope& scope,
                                  bool search) {
  const auto as_usual = [&](const Estimate& estimate) {
    return motion_.lost() || estimate.score > kUsualScore * look_.expected_score();
  };
  const int lit_level = scope.coarse() && scope.coarse_finest > finest_ ? scope.coarse_finest : -1;
  Estimate best;
  best.T_camera_object = hypotheses.poses[0];
  std::size_t tried = 0;
  std::array<Pose, Starts::kMost + 1> T_tried;  // the best start twice, once from a finer level
  const auto try_start = [&](const Estimate& start, int fine_coarsest) {
    const Estimate estimate = fine_stage(start.T_camera_object, fine_coarsest, lit_level);
    T_tried[tried++] = estimate.T_camera_object;
    if (best.score < 0 || estimate.score > best.score) best = estimate;
    return is_good(best) && as_usual(best);
  };
  // What the coarse levels have answered is mostly near enough for the finest, and then is corrected little there.
  const int one_finer = std::max(scope.coarse_finest - 1, finest_);
  bool found = starts.best().score > 0 && one_finer > finest_ && try_start(starts.best(), finest_);
  if (found && corner_motion(starts.best().T_camera_object, best.T_camera_object) > kMostCorrection) {
    found = false;
    best.score = -1;
  }
  for (std::size_t i = 0; i < starts.count() && !found; ++i) found = try_start(starts[i], one_finer);
  const bool challenge = options_.challenge && search && scope.coarse();
  if (challenge && !as_usual(best)) best = recolored(best, hypotheses.poses[0], scope);
  if (challenge && !as_usual(best)) {
    const Estimate doubtful = best;
    const auto same = [&](const Pose& pose) { return corner_motion(pose, doubtful.T_camera_object) < kSamePixels; };
    // What has been come to from apart, and from wherever else, need not be come to from all around.
    const bool agreed = hypotheses.count > 1 && tried > 2 &&
                        corner_motion(hypotheses.poses[0], hypotheses.poses[1]) > kApart &&
                        std::all_of(T_tried.begin(), T_tried.begin() + tried, same);
    best = challenged(doubtful, scope, !agreed);
    if (is_good(best) && !as_usual(best) && same(best.T_camera_object)) look_.confirm(best.score);
  }
  return best;
}

Estimate Tracker::Impl::recolored(const Estimate& doubtful, const Pose& T_start, const Scope& scope) {
  Choice& coarse_color = look_.optics.coarse_color;
  if (!options_.coarse_color || image_.grey() || coarse_color.measured > 0) return doubtful;
  coarse_color.on = !coarse_color.on;
  const Estimate coarse = coarse_stage(T_start, true, scope.coarsest, scope.coarse_finest);
  const Estimate estimate = fine_stage(coarse.T_camera_object, std::max(scope.coarse_finest - 1, finest_), -1);
  if (estimate.score > kUsualScore * look_.expected_score() && estimate.score > kClearlyBetter * doubtful.score) {
    return estimate;
  }
  coarse_color.on = !coarse_color.on;
  return doubtful;
}

Estimate Tracker::Impl::challenged(const Estimate& doubtful, const Scope& scope, bool turn) {
  Estimate best = doubtful;
  const int fine_coarsest = std::max(scope.coarse_finest - 1, finest_);
  const auto compete = [&](const Pose& T_start) {
    const Estimate estimate = fine_stage(T_start, fine_coarsest, -1);
    if (estimate.score > best.score) best = estimate;
    return best.score > kUsualScore * look_.expected_score();
  };
  // Fast motion blurs, by how much is not known at first.
  if (options_.motion_blur && moved_ && corner_motion(motion_.pose(), best.T_camera_object) > kTellingMotion) {
    const double before = look_.exposure;
    double found = before;
    for (const double exposure : {0.25, 0.5, 0.75}) {
      if (std::abs(exposure - before) < 0.1) continue;
      look_.exposure = exposure;
      const double score = best.score;
      compete(best.T_camera_object);
      if (best.score > kClearlyBetter * score) found = exposure;
    }
    // A shutter that is known does not change at once, but motion may within a frame: soon it is looked at again.
    const bool known = look_.exposure_known() && before > 0;
    look_.exposure = known ? before : found;
    if (known && found != before) look_.exposure_settled = Look::kSettled;
    if (best.score > kUsualScore * look_.expected_score()) return best;
  }
  if (!turn) return best;
  Starts starts;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {-kChallengeTurn, kChallengeTurn}) {
      const Pose T_start = turned(doubtful.T_camera_object, Eigen::Vector3d::Unit(axis), angle);
      starts.add(coarse_stage(T_start, true, scope.coarsest, scope.coarse_finest));
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (compete(starts[i].T_camera_object)) break;
  }
  return best;
}

}  // namespace holdfast
