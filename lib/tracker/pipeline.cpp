#include "tracker/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/stopwatch.hpp"
#include "holdfast/error.hpp"

namespace holdfast {
namespace {

/// Pixels that the prediction may be off, of a frame and of the one before, to go to the finest level at once.
constexpr double kMostSurprise = 2;
/// Poses that move the object's corners by less than so many pixels are the same start.
constexpr double kSamePixels = 1;
constexpr std::size_t kMostStarts = 3;
/// Pixels that the finest level may correct a coarse answer by to be believed without the level between.
constexpr double kMostCorrection = 1.5;
/// Least side of the object on a level that is still worth comparing there, pixels.
constexpr double kLeastSide = 20;
/// Turns that a lost object is tried with, radians: about what the coarsest level converges from.
constexpr double kSearchTurn = 0.35;
/// Times that a found object is aligned again, at most, until it stays where it is.
constexpr int kMostSettling = 4;
constexpr double kSettledPixels = 1.5;
/// Share of the usual coarse score below which a candidate is not worth a finer level.
constexpr double kHopelessScore = 0.1;
constexpr int kMostCoarseAlignments = 3;
/// Times a usual frame's work, and nominal milliseconds at least, after which a frame tries no other start.
constexpr double kMostWork = 3, kLeastMs = 6;
/// Share of texture in what is usually known, below which the whole picture is not searched by texture.
constexpr double kLeastTrust = 0.2;
/// Share of the lines near a found contour that must be near a turned one for the shape to be symmetrical, and the
/// turn, radians, since it was held last from which it may have turned on into another of its symmetries.
constexpr double kAlike = 0.85, kMistakableTurn = 0.8;
/// Of a frame's starts by the outline, those followed to the finest level.
constexpr std::size_t kMostOutlineStarts = 2;
/// Inlier ratio of texture that needs no help in the first frame.
constexpr double kClearRatio = 0.7;
/// Share of texture in what is usually known, above which the finest level alone converges from a good prediction.
constexpr double kLeads = 0.5;

}  // namespace

FrameResult Pipeline::track(const UploadFrame& upload, std::optional<double> time) {
  const double t = frame_time(time);
  choose_finest_level();
  upload_ = &upload;
  uploaded_ = {};
  prior_ = state_.motion.predict(t);
  aligner_.start_frame(state_, prior_);
  double total = 0;
  FrameResult result;
  {
    const Stopwatch watch(total);
    if (!state_.seen) see(prior_.T_camera_object, false, state_);
    const Pose& T_start = tuning_.predict_velocity ? prior_.T_camera_object : state_.motion.pose();
    Alignment best = tuning_.paper() ? follow_once(T_start, state_) : follow(prior_);
    if (!held(best) && !state_.seen && start_as_given(prior_.T_camera_object)) {
      best = aligner_.align(prior_.T_camera_object, fine_plan(state_.finest, state_), state_);
    }
    if (!held(best) && tuning_.recovery && !tuning_.paper()) {
      // Where both may find it they take turns.
      const bool outline = searches_by_outline(state_) && state_.motion.lost();
      if (searches_by_texture(state_) && !(outline && state_.motion.misses() % 2 == 0)) {
        relocalize(prior_, best);
      } else if (outline) {
        relocalize_by_outline(prior_, best);
      }
    }
    result = report(best, state_);
    last_ = best;
    if (result.status == Status::held) {
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
  if (!first) return follow_fully(hypotheses(prior), true, state_);
  // The model's light and the camera's are not known yet: the outline, which they do not touch, mends the pose first.
  tried_ = state_;
  tried_.textured = false;
  const Alignment outline = follow_fully({prior.T_camera_object}, false, tried_);
  see(outline.T_camera_object, false, state_);
  const Alignment mended = aligner_.align(outline.T_camera_object, fine_plan(state_.finest, state_), state_);
  if (held(mended) && as_usual(mended)) return mended;
  const Alignment given = follow_fully({prior.T_camera_object}, true, state_);
  return given.score > mended.score ? given : mended;
}

std::optional<Alignment> Pipeline::follow_directly(const MotionPrior& prior) {
  const double most = kMostSurprise * (1 << state_.finest);
  const bool confident = state_.fresh() || (state_.motion.moving() && state_.prediction_error <= most);
  if (!confident || state_.motion.lost()) return {};
  const Rect object = view_.bounds(prior.T_camera_object);
  if (object.empty()) return {};
  const bool contour_leads = !state_.textured || state_.usual.texture_trust < kLeads;
  upload(object, (contour_leads ? 2 * ContourConstraints::kReach : filter_.radius() + 4) * (1 << state_.finest) +
                     static_cast<int>(2 * most));
  AlignmentPlan plan = fine_plan(state_.finest, state_);
  plan.most_motion = most;
  const Alignment alignment = aligner_.align(prior.T_camera_object, plan, state_);
  if (!held(alignment) || !as_usual(alignment)) return {};
  return alignment;
}

Alignment Pipeline::follow_once(const Pose& T_start, const TrackingState& state) {
  const Rect object = view_.bounds(T_start);
  if (!object.empty()) upload(object, filter_.radius() + 4);
  return aligner_.align_once(T_start, state);
}

std::vector<Pose> Pipeline::hypotheses(const MotionPrior& prior) const {
  std::vector<Pose> poses;
  const MotionFilter& motion = state_.motion;
  if (state_.suspected) poses.push_back(*state_.suspected);
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
  upload(wanted, std::max(aligner_.contour().margin(), ((filter_.radius() + 4) << coarsest) +
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
    AlignmentPlan plan;
    plan.coarsest = coarsest;
    plan.finest = coarse_finest;
    plan.shift_search = search && tuning_.shift_search;
    plan.redraws = 0;
    plan.measure = false;
    plan.expected = false;
    for (const Pose& pose : hypotheses) {
      starts.push_back(aligner_.align(pose, plan, state));
      if (!state.motion.lost() && starts.back().solved && as_usual(starts.back())) break;
      if (aligner_.nominal_ms() > 0.5 * tuning_.recovery_budget_ms) break;
    }
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Alignment& a, const Alignment& b) { return a.score > b.score; });
  }
  for (const Pose& pose : hypotheses) {  // where the coarse levels see too little
    Alignment plain;
    plain.T_camera_object = pose;
    starts.push_back(plain);
  }
  // What is about to be lost is worth every start; what is lost is looked for in the next frames, too.
  const auto most_ms = [&](const Alignment& alignment) {
    if (held(alignment, state)) return std::max(kLeastMs, kMostWork * state.usual.frame_ms);
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
    plan.expected = !state.motion.lost();
    const Alignment alignment = aligner_.align(start.T_camera_object, plan, state);
    if (best.score < 0 || alignment.score > best.score) best = alignment;
    if (held(best, state) && (as_usual(best) || state.motion.lost())) break;
  }
  if (held(best, state) && best.has_texture && coarsest > finest && starts[0].solved && !state.motion.lost()) {
    best.coarse_score = starts[0].texture.score();
  }
  return best;
}

AlignmentPlan Pipeline::fine_plan(int coarsest, const TrackingState& state) const {
  AlignmentPlan plan;
  plan.coarsest = coarsest;
  plan.finest = state.finest;
  plan.expected = state.motion.moving() && !state.motion.lost() && tuning_.expected_motion && tuning_.predict_velocity;
  return plan;
}

Alignment Pipeline::settled(const Alignment& alignment) {
  Alignment best = alignment;
  for (int i = 0; i < kMostSettling; ++i) {
    AlignmentPlan plan = fine_plan(state_.finest, state_);
    plan.expected = false;
    const Alignment next = aligner_.align(best.T_camera_object, plan, state_);
    if (!next.solved || next.score < best.score) break;
    const double motion = aligner_.corner_motion(best.T_camera_object, next.T_camera_object);
    best = next;
    if (motion < kSettledPixels) break;
  }
  return best;
}

/// Draws as the relocalizer wants it: what the silhouette adds is as good a sign as texture, so that no margin is
/// dropped, and nothing is known of motion.
class Pipeline::LevelDrawer : public ViewDrawer {
 public:
  explicit LevelDrawer(Pipeline& pipeline) : pipeline_(pipeline), imaging_(pipeline.state_.imaging) {
    imaging_.surviving_share = 0;
    imaging_.exposure = {};
  }
  bool draw(const Pose& T_camera_object, int level) override {
    return pipeline_.aligner_.draw(T_camera_object, level, 1, pipeline_.state_, imaging_);
  }

 private:
  Pipeline& pipeline_;
  ImagingState imaging_;
};

Alignment Pipeline::from_candidate(const PoseCandidate& candidate, const Relocalizer::Levels& levels) {
  AlignmentPlan plan;
  plan.coarsest = levels.coarsest;
  plan.finest = std::max(levels.coarsest - 1, state_.finest);
  plan.shift_search = true;
  plan.redraws = 0;
  plan.measure = plan.expected = plan.contour = false;  // texture proposed it
  Alignment start = aligner_.align(candidate.T_camera_object, plan, state_);
  for (int i = 1; i < kMostCoarseAlignments && start.solved && start.score < 1; ++i) {
    const Alignment again = aligner_.align(start.T_camera_object, plan, state_);
    if (again.score <= start.score) break;
    start = again;
  }
  return start;
}

void Pipeline::relocalize(const MotionPrior& prior, Alignment& best) {
  const auto take_better = [&](const Alignment& found) {
    if (found.score > best.score) best = found;
  };
  const Rect whole{0, 0, image_.camera().width, image_.camera().height};
  upload(whole, 0);
  relocalizer_.begin(state_.motion.pose());
  LevelDrawer drawer(*this);
  const int finest = state_.finest;
  const auto fine_from = [&](const Pose& T_start, int coarsest) {
    AlignmentPlan plan = fine_plan(coarsest, state_);
    plan.expected = false;
    return aligner_.align(T_start, plan, state_);
  };
  const double budget = tuning_.recovery_budget_ms;
  const auto spent = [&] { return aligner_.nominal_ms() >= budget; };
  const bool was_lost = state_.motion.lost();
  if (was_lost && state_.motion.misses() < 12 && state_.motion.moving()) {
    const int level = std::min(finest + 1, tuning_.levels - 1);
    image_.enqueue_blur(level, coarser(uploaded_, level));
    for (const PoseCandidate& part : relocalizer_.search_parts(drawer, prior.T_camera_object, level)) {
      take_better(fine_from(part.T_camera_object, level));
      if (held(best) || spent()) break;
    }
  }
  if (!was_lost && spent()) return;  // the search begins in the next frame
  if (!held(best)) {
    const Relocalizer::Levels levels = relocalizer_.levels_for(state_.motion.pose(), finest, tuning_.levels);
    for (int level = std::max(levels.coarsest - 1, finest); level <= levels.swept; ++level) {
      image_.enqueue_blur(level, coarser(uploaded_, level));
    }
    const double left = std::max(0.0, budget - aligner_.nominal_ms());
    const std::vector<PoseCandidate> candidates = relocalizer_.search(drawer, levels, left);
    aligner_.shift_search().enqueue_gradients(image_, levels.coarsest);
    std::vector<Alignment> starts;
    std::vector<PoseCandidate> kept;
    for (const PoseCandidate& candidate : candidates) {
      if (spent() && !starts.empty()) {  // the next frame looks at it
        kept.push_back(candidate);
        continue;
      }
      Alignment start = from_candidate(candidate, levels);
      if (start.score < kHopelessScore) continue;
      kept.push_back({start.T_camera_object, start.score});
      starts.push_back(std::move(start));
    }
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Alignment& a, const Alignment& b) { return a.score > b.score; });
    relocalizer_.keep(std::move(kept));
    for (const Alignment& start : starts) {
      take_better(fine_from(start.T_camera_object, std::max(levels.coarsest - 2, finest)));
      if (held(best) || spent()) break;
    }
    if (is_probable(best, context(best, state_))) {
      for (const PoseCandidate& rival : relocalizer_.rivals(drawer, best.T_camera_object, levels.closer, finest)) {
        aligner_.shift_search().enqueue_gradients(image_, levels.coarsest);
        const Alignment start = from_candidate(rival, levels);
        if (start.score < kHopelessScore) continue;
        take_better(settled(fine_from(start.T_camera_object, std::max(levels.coarsest - 2, finest))));
      }
    }
  }
  if (is_probable(best, context(best, state_))) best = settled(best);
}

bool Pipeline::searches_by_texture(const TrackingState& state) const {
  return state.textured && state.usual.texture_trust >= kLeastTrust;
}

bool Pipeline::searches_by_outline(const TrackingState& state) const {
  return tuning_.contour && (!state.textured || state.usual.texture_trust < kLeads);
}

void Pipeline::relocalize_by_outline(const MotionPrior& prior, Alignment& best) {
  const Pose& T_last = state_.motion.pose();
  upload({0, 0, image_.camera().width, image_.camera().height}, 0);
  std::vector<Alignment> starts;
  for (const Pose& T : outline_search_.starts(T_last, prior.T_camera_object, view_.bounds(T_last), state_.colors)) {
    AlignmentPlan plan;
    plan.coarsest = aligner_.contour().coarsest(T, state_.finest);
    plan.finest = std::max(plan.coarsest - 1, state_.finest);
    plan.redraws = 0;
    plan.measure = plan.expected = false;
    Alignment start = aligner_.align(T, plan, state_);
    if (start.solved) starts.push_back(std::move(start));
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Alignment& a, const Alignment& b) { return a.score > b.score; });
  for (std::size_t i = 0; i < std::min(kMostOutlineStarts, starts.size()); ++i) {
    AlignmentPlan plan = fine_plan(state_.finest, state_);
    plan.expected = false;
    Alignment found = aligner_.align(starts[i].T_camera_object, plan, state_);
    if (!found.solved || found.score <= best.score) continue;
    if (is_probable(found, context(found, state_))) tell_apart(found);
    best = found;
  }
}

void Pipeline::tell_apart(Alignment& found) {
  const Pose& T_last = state_.motion.pose();
  const auto turn = [&](const Pose& T) { return rotation_angle(T.linear() * T_last.linear().transpose()); };
  const auto near = [&](const Pose& T) {
    const ContourTerms terms = aligner_.contour().linearize(T, state_.finest, kCloseSearch);
    return terms.sums.near / std::max(1.0, terms.sums.lines);
  };
  const double usual = near(found.T_camera_object);
  Pose T_nearest = found.T_camera_object;
  bool symmetric = false;
  for (const Pose& symmetry : symmetries_) {
    const Pose T = found.T_camera_object * symmetry;
    if (near(T) < kAlike * usual) continue;
    symmetric = true;
    if (turn(T) < turn(T_nearest)) T_nearest = T;
  }
  if (!symmetric) return;
  if (turn(T_nearest) < turn(found.T_camera_object)) {
    AlignmentPlan plan = fine_plan(state_.finest, state_);
    plan.expected = false;
    const Alignment nearest = aligner_.align(T_nearest, plan, state_);
    if (nearest.solved) found = nearest;
  }
  found.mistakable = turn(found.T_camera_object) > kMistakableTurn;
}

}  // namespace holdfast
