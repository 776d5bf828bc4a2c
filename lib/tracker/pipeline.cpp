#include "tracker/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"

namespace holdfast {
namespace {

/// Steps of texture, pixels, that end its iterations: each is about a quarter of the one before.
constexpr double kConvergedTexture = 0.1;
/// Pixels that the prediction may be off, of a frame and of the one before, to go to the finest level at once.
constexpr double kMostSurprise = 2;
/// Poses that move the object's corners by less than so many pixels are the same start.
constexpr double kSamePixels = 1;
constexpr std::size_t kMostStarts = 3;
/// Standard deviation of a first pose, object radii and radians, where only the outline can tell better: it has other
/// edges to go to.
constexpr double kGivenPose = 0.1;
/// Pixels that a first pose may be off for the colours beside it to be the object's.
constexpr double kSameColors = 2;
/// Times that they are learned anew at most.
constexpr int kMostRelearned = 3;
/// Least side of the object on a level that is still worth comparing there, pixels.
constexpr double kLeastSide = 20;
/// Turns that a lost object is tried with, radians: about what the coarsest level converges from.
constexpr double kSearchTurn = 0.35;
/// Times a usual frame's work, and nominal milliseconds at least, after which a frame tries no other start.
constexpr double kMostWork = 3, kLeastMs = 6;
/// Inlier ratio of texture that needs no help in the first frame.
constexpr double kClearRatio = 0.7;

}  // namespace

FrameResult Pipeline::track(const UploadFrame& upload, std::optional<double> time) {
  const double t = frame_time(time);
  choose_finest_level();
  upload_ = &upload;
  uploaded_ = {};
  prior_ = state_.motion.predict(t);
  if (!state_.motion.started() && !state_.textured) {
    prior_.covariance = kGivenPose * kGivenPose * Matrix6::Identity();
  }
  aligner_.start_frame(state_, prior_);
  double total = 0;
  FrameResult result;
  {
    const Stopwatch watch(total);
    if (!state_.seen) see(prior_.T_camera_object, Given::nearly, state_);
    const Pose& T_start = tuning_.predict_velocity ? prior_.T_camera_object : state_.motion.pose();
    state_.print_missing = false;
    Alignment best = tuning_.paper() ? follow_once(T_start, state_) : follow(prior_);
    doubt_texture(best);
    if (!state_.seen && !state_.textured && !state_.motion.lost()) follow_from_there(best, state_);
    if (!held(best) && !state_.seen && !state_.motion.lost()) {
      const std::optional<Pose> T_first = start_as_given(prior_.T_camera_object, best.T_camera_object);
      if (T_first) best = aligner_.align(*T_first, fine_plan(state_.finest, state_), state_);
    }
    if (!held(best) && tuning_.recovery && !tuning_.paper()) {
      // Both searches take turns. Texture, where it leads, has the first frames to itself: its parts are found near by.
      const bool outline =
          tuning_.contour && (outline_leads(state_) ? state_.motion.lost() : state_.motion.misses() >= kSoon);
      if (searches_by_texture(state_) && !(outline && state_.motion.misses() % 2 == 0)) {
        relocalize(prior_, best);
      } else if (outline) {
        if (!state_.textured && !album_.empty() && state_.motion.misses() % kSnapshotsEvery == kSnapshotsEvery - 1) {
          relocalize_by_snapshots(prior_, best);
        } else {
          relocalize_by_outline(best);
        }
      }
    }
    look_for_print(best);
    tell_from_mirrored(best, t);
    result = report(best, state_);
    last_ = best;
    if (held(best)) {
      commit(best, t);
    } else {
      miss(best, t, result);
    }
  }
  result.ms = aligner_.times();
  result.ms.total = total;
  return result;
}

Alignment Pipeline::follow(const MotionPrior& prior) {
  const bool first = !state_.seen && state_.textured && tuning_.contour;
  const std::optional<Alignment> direct = follow_directly(prior);
  if (direct && (!first || direct->texture.inlier_ratio() > kClearRatio)) return *direct;
  if (!first) {
    const Alignment best = follow_fully(hypotheses(prior), true, state_);
    if (state_.textured || state_.motion.lost() || best.score >= 1) return best;
    // Coarse levels may lead an outline to another edge, from where nothing leads back.
    AlignmentPlan plan = fine_plan(state_.finest, state_);
    plan.still = true;
    const Alignment still = aligner_.align(prior.T_camera_object, plan, state_);
    return still.solved && still.score > best.score ? still : best;
  }
  // The model's light and the camera's are not known yet: the outline, which they do not touch, mends the pose first.
  tried_ = state_;
  tried_.textured = false;
  Alignment outline = follow_fully({prior.T_camera_object}, false, tried_), mended;
  for (const bool again : {false, true}) {
    if (again && !follow_from_there(outline, tried_)) break;
    see(outline.T_camera_object, Given::nearly, state_);
    const Alignment from_there = aligner_.align(outline.T_camera_object, fine_plan(state_.finest, state_), state_);
    if (held(from_there) && as_usual(from_there)) return from_there;
    if (from_there.score > mended.score) mended = from_there;
  }
  const Alignment given = follow_fully({prior.T_camera_object}, true, state_);
  return given.score > mended.score ? given : mended;
}

/// Colours beside a first pose that is off lead only part of the way: they are learned anew where it is found. False
/// where nothing better comes of it.
bool Pipeline::follow_from_there(Alignment& best, TrackingState& state) {
  if (tuning_.paper() || !tuning_.contour) return false;
  bool moved = false;
  Pose T_colors = prior_.T_camera_object;
  for (int i = 0; i < kMostRelearned; ++i) {
    if (!best.solved || aligner_.corner_motion(T_colors, best.T_camera_object) < kSameColors) break;
    T_colors = best.T_camera_object;
    const ColorHistograms colors = state.colors;
    see(T_colors, Given::nearly, state);
    const Alignment again = follow_fully({T_colors}, false, state);
    if (again.score < best.score) {
      state.colors = colors;
      aligner_.contour().use_colors(colors);
      break;
    }
    best = again;
    moved = true;
  }
  return moved;
}

std::optional<Alignment> Pipeline::follow_directly(const MotionPrior& prior) {
  const double most = kMostSurprise * (1 << state_.finest);
  const bool confident = state_.fresh() || (state_.motion.moving() && state_.prediction_error <= most);
  if (!confident || state_.motion.lost()) return {};
  const Rect object = view_.bounds(prior.T_camera_object);
  if (object.empty()) return {};
  const bool contour_leads = !state_.textured || state_.usual.texture_trust < kTextureLeads;
  upload(object, (contour_leads ? 2 * ContourConstraints::kReach : ImageFilter::kMargin) * (1 << state_.finest) +
                     static_cast<int>(2 * most));
  AlignmentPlan plan = fine_plan(state_.finest, state_);
  plan.most_motion = most;
  const Pose& T_start = tuning_.predict_velocity ? prior.T_camera_object : state_.motion.pose();
  const Alignment alignment = aligner_.align(T_start, plan, state_);
  if (!held(alignment) || !as_usual(alignment)) return {};
  return alignment;
}

Alignment Pipeline::follow_once(const Pose& T_start, const TrackingState& state) {
  const Rect object = view_.bounds(T_start);
  if (!object.empty()) upload(object, ImageFilter::kMargin);
  return aligner_.align_once(T_start, state);
}

std::vector<Pose> Pipeline::hypotheses(const MotionPrior& prior) const {
  std::vector<Pose> poses;
  const MotionFilter& motion = state_.motion;
  if (state_.suspected) poses.push_back(*state_.suspected);
  if (motion.lost() && outline_leads(state_)) {  // the search by outline finds it: one of the two a frame
    const bool predicted = tuning_.predict_velocity && motion.misses() % 2 == 0;
    poses.push_back(predicted ? prior.T_camera_object : motion.pose());
    return poses;
  }
  if (tuning_.predict_velocity) poses.push_back(prior.T_camera_object);
  poses.push_back(motion.pose());
  if (motion.lost()) {
    const int way = motion.misses();
    const double angle = (way % 2 == 0 ? 1 : -1) * kSearchTurn * (1 + (way / 6) % 2);
    poses.push_back(turned_about_center(prior.T_camera_object, extent_, Eigen::Vector3d::Unit((way / 2) % 3), angle));
  }
  return poses;
}

Alignment Pipeline::follow_fully(const std::vector<Pose>& hypotheses, bool search, const TrackingState& state) {
  Alignment best;
  best.T_camera_object = hypotheses[0];
  best.imaging = state.imaging;
  Rect wanted;
  for (const Pose& pose : hypotheses) wanted = united(wanted, view_.bounds(pose));
  if (wanted.empty()) return best;
  const Rect object = view_.bounds(hypotheses[0]);
  const double side = std::sqrt(0.6 * object.width * object.height);
  const int finest = state.finest;
  int coarsest = 0;
  while (coarsest + 1 < tuning_.levels && side / (2 << coarsest) >= kLeastSide) ++coarsest;
  coarsest = std::max(coarsest, std::min(finest + 1, tuning_.levels - 1));
  const int coarse_finest = std::max(coarsest - 1, finest);
  upload(wanted, std::max(aligner_.contour().margin(), (ImageFilter::kMargin << coarsest) +
                                                           (search ? tuning_.search_radius : 0) +
                                                           static_cast<int>(0.1 * side)));

  std::vector<Alignment> starts;
  if (coarsest > finest) {
    if (state.textured) {
      const Stopwatch watch(aligner_.times().filter);
      for (int level = coarse_finest; level <= coarsest; ++level) image_.enqueue_blur(level, coarser(uploaded_, level));
      if (search) aligner_.shift_search().enqueue_gradients(image_, coarsest);
      device_.impl().queue.flush();
    }
    AlignmentPlan plan = coarse_plan(coarsest);
    plan.shift_search = search && tuning_.shift_search;
    for (const Pose& pose : hypotheses) {
      starts.push_back(aligner_.align(pose, plan, state));
      if (!state.motion.lost() && starts.back().solved && as_usual(starts.back())) break;
      if (aligner_.nominal_ms() > 0.5 * tuning_.recovery_budget_ms) break;
    }
    std::ranges::stable_sort(starts, std::greater{}, &Alignment::score);
  }
  for (const Pose& pose : hypotheses) {  // where the coarse levels see too little
    Alignment plain;
    plain.T_camera_object = pose;
    starts.push_back(plain);
  }
  // What is about to be lost is worth every start; what is lost is looked for in the next frames, too.
  const auto most_ms = [&](const Alignment& alignment) {
    if (held(alignment, state) && state.usual.frame_ms > 0) {
      return std::max(kLeastMs, kMostWork * state.usual.frame_ms);
    }
    return state.motion.lost() ? 0.5 * tuning_.recovery_budget_ms : std::numeric_limits<double>::infinity();
  };
  std::vector<Pose> tried;
  for (const Alignment& start : starts) {
    const auto same = [&](const Pose& pose) {
      return aligner_.corner_motion(pose, start.T_camera_object) < kSamePixels;
    };
    if (std::any_of(tried.begin(), tried.end(), same)) continue;
    if (tried.size() == kMostStarts) break;
    if (!tried.empty() && aligner_.nominal_ms() > most_ms(best)) break;
    tried.push_back(start.T_camera_object);
    AlignmentPlan plan = fine_plan(std::max(coarse_finest - 1, finest), state);
    plan.light_from = start.solved && coarse_finest > finest ? coarse_finest : -1;
    plan.expected = !state.motion.lost() && tuning_.expected_motion && tuning_.predict_velocity;
    const Alignment alignment = aligner_.align(start.T_camera_object, plan, state);
    if (best.score < 0 || alignment.score > best.score) best = alignment;
    if (held(best, state) && (as_usual(best) || state.motion.lost())) break;
  }
  if (held(best, state) && best.has_texture && coarsest > finest && starts[0].solved && !state.motion.lost()) {
    best.coarse_score = starts[0].texture.score();
  }
  return best;
}

AlignmentPlan Pipeline::coarse_plan(int coarsest) const {
  AlignmentPlan plan;
  plan.coarsest = coarsest;
  plan.finest = std::max(coarsest - 1, state_.finest);
  plan.redraws = 0;
  plan.measure = plan.expected = false;
  return plan;
}

Alignment Pipeline::align_anywhere(const Pose& T_start, int coarsest) {
  AlignmentPlan plan = fine_plan(coarsest, state_);
  plan.expected = false;
  return aligner_.align(T_start, plan, state_);
}

AlignmentPlan Pipeline::fine_plan(int coarsest, const TrackingState& state) const {
  AlignmentPlan plan;
  plan.coarsest = coarsest;
  plan.finest = state.finest;
  if (state.textured) plan.converged = kConvergedTexture;
  plan.expected = state.motion.moving() && !state.motion.lost() && tuning_.expected_motion && tuning_.predict_velocity;
  return plan;
}

}  // namespace holdfast
