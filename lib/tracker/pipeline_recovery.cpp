// How a lost object is looked for.
#include <algorithm>
#include <functional>
#include <utility>

#include "texture/print_agreement.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {
namespace {

/// Times that a found object is aligned again, at most, until it stays where it is.
constexpr int kMostSettling = 4;
constexpr double kSettledPixels = 1.5;
/// Share of the usual coarse score below which a candidate is not worth a finer level.
constexpr double kHopelessScore = 0.1;
constexpr int kMostCoarseAlignments = 3;
/// A candidate that moves the object's corners by less than so many pixels from the best pose so far leads there again.
constexpr double kTriedPixels = 8;
/// Share of texture in what is usually known, below which the whole picture is not searched by texture.
constexpr double kLeastTrust = 0.2;
/// Share of the lines near a found contour that must be near a turned one for the shape to be symmetrical, and the
/// turn, radians, since it was held last from which it may have turned on into another of its symmetries.
constexpr double kAlike = 0.85, kMistakableTurn = 0.8;
/// Pixels of a snapshot that a place is scored with, about.
constexpr double kScoredPixels = 200;
/// Inlier ratio and reliability of texture above which the print is there.
constexpr double kMuchAgrees = 0.3, kPrintBelieved = 0.2;

/// The model's print is there, half hidden as it may be.
bool shows_print(const Alignment& alignment) {
  return alignment.texture.inlier_ratio() > kMuchAgrees && alignment.texture.reliability > kPrintBelieved;
}

}  // namespace

Alignment Pipeline::settled(const Alignment& alignment) {
  Alignment best = alignment;
  for (int i = 0; i < kMostSettling; ++i) {
    const Alignment next = align_anywhere(best.T_camera_object, state_.finest);
    if (!next.solved || next.score < best.score) break;
    const double motion = aligner_.corner_motion(best.T_camera_object, next.T_camera_object);
    best = next;
    if (motion < kSettledPixels) break;
  }
  return best;
}

Alignment Pipeline::from_candidate(const PoseCandidate& candidate, const Relocalizer::Levels& levels) {
  AlignmentPlan plan = coarse_plan(levels.coarsest);
  plan.shift_search = true;
  plan.contour = false;  // texture proposed it
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
  // The silhouette is as good a sign as texture: no margin is dropped. Motion is unknown.
  ImagingState imaging = state_.imaging;
  imaging.surviving_share = 0;
  imaging.exposure = {};
  const DrawView draw = [&](const Pose& T, int level) { return aligner_.draw(T, level, 1, state_, imaging); };
  const int finest = state_.finest;
  const double budget = tuning_.recovery_budget_ms;
  const auto spent = [&] { return aligner_.nominal_ms() >= budget; };
  const bool was_lost = state_.motion.lost();
  if (was_lost && state_.motion.misses() < kSoon && state_.motion.moving()) {
    const int level = std::min(finest + 1, tuning_.levels - 1);
    image_.enqueue_blur(level, coarser(uploaded_, level));
    for (const PoseCandidate& part : relocalizer_.search_parts(draw, prior.T_camera_object, level)) {
      take_better(align_anywhere(part.T_camera_object, level));
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
    const std::vector<PoseCandidate> candidates = relocalizer_.search(draw, levels, left);
    aligner_.shift_search().enqueue_gradients(image_, levels.coarsest);
    std::vector<Alignment> starts;
    std::vector<PoseCandidate> kept;
    const auto leads_there = [&](const Pose& T) {  // what has been tried would be tried in each frame, and little else
      return best.solved && aligner_.corner_motion(T, best.T_camera_object) < kTriedPixels;
    };
    for (const PoseCandidate& candidate : candidates) {
      if (leads_there(candidate.T_camera_object)) continue;
      if (spent() && !starts.empty()) {  // the next frame looks at it
        kept.push_back(candidate);
        continue;
      }
      Alignment start = from_candidate(candidate, levels);
      if (start.score < kHopelessScore || leads_there(start.T_camera_object)) continue;
      kept.push_back({start.T_camera_object, start.score});
      starts.push_back(std::move(start));
    }
    std::ranges::stable_sort(starts, std::greater{}, &Alignment::score);
    relocalizer_.keep(std::move(kept));
    for (const Alignment& start : starts) {
      take_better(align_anywhere(start.T_camera_object, std::max(levels.coarsest - 2, finest)));
      if (held(best) || spent()) break;
    }
    if (is_probable(best, context(best, state_))) {
      for (const PoseCandidate& rival : relocalizer_.rivals(draw, best.T_camera_object, levels.closer, finest)) {
        aligner_.shift_search().enqueue_gradients(image_, levels.coarsest);
        const Alignment start = from_candidate(rival, levels);
        if (start.score < kHopelessScore) continue;
        take_better(settled(align_anywhere(start.T_camera_object, std::max(levels.coarsest - 2, finest))));
      }
    }
  }
  if (is_probable(best, context(best, state_))) best = settled(best);
}

void Pipeline::look_for_print(const Alignment& alignment) {
  if (!state_.textured || tuning_.paper() || !held(alignment)) return;
  if (shows_print(alignment)) return;
  if (!shows_all(alignment, state_.usual.outline())) return;
  if (!state_.motion.lost() && state_.usual.held_frames > 0) return;  // it has been seen: something may cover it
  const Pose& T = alignment.T_camera_object;
  const int level = state_.finest, around = ImageFilter::kMargin << level;
  upload(view_.bounds(T), around);
  if (!aligner_.draw(T, level, 1, state_, alignment.imaging)) return;
  image_.enqueue_blur(level, coarser(grown(view_.bounds(T), around), level));
  state_.print_missing =
      print_agreement(device_.impl(), view_, image_, levels_[static_cast<std::size_t>(level)]).missing();
  // What light is learned from is of the view drawn last.
  TextureState scratch = alignment.imaging.texture;
  aligner_.texture().start_level(view_, level);
  aligner_.texture().linearize(view_, image_, Pose::Identity(),
                               {level, level, std::max(1, alignment.texture.row_stride), false, false}, scratch);
}

bool Pipeline::searches_by_texture(const TrackingState& state) const {
  return state.textured && state.usual.texture_trust >= kLeastTrust;
}

bool Pipeline::outline_leads(const TrackingState& state) const {
  return tuning_.contour && (!state.textured || state.usual.texture_trust < kTextureLeads);
}

void Pipeline::relocalize_by_snapshots(const MotionPrior& prior, Alignment& best) {
  upload({0, 0, image_.camera().width, image_.camera().height}, 0);
  const int finest = state_.finest;
  const Relocalizer::Levels levels = relocalizer_.levels_for(state_.motion.pose(), finest, tuning_.levels);
  for (int level = std::max(levels.coarsest - 1, finest); level <= levels.swept; ++level) {
    image_.enqueue_blur(level, coarser(uploaded_, level));
  }
  const Level& swept = levels_[static_cast<std::size_t>(levels.swept)];
  aligner_.shift_search().enqueue_gradients(image_, levels.swept);
  const auto align = [&](const Snapshot& snapshot) {
    const Eigen::Vector2d center = swept.camera.project(snapshot.T_camera_object * extent_.p_object_center);
    const Rect shifts{-static_cast<int>(center.x()), -static_cast<int>(center.y()), swept.width, swept.height};
    const ShiftSearch::Result shift =
        aligner_.shift_search().search(view_, image_, levels.swept, shifts, kScoredPixels);
    const Pose T_start = shifted(snapshot.T_camera_object, extent_.p_object_center, swept.camera, shift);
    const Alignment start = aligner_.align(T_start, coarse_plan(levels.coarsest), state_);
    if (!start.solved || start.score < kHopelessScore) return start;
    return align_anywhere(start.T_camera_object, std::max(levels.coarsest - 2, finest));
  };
  const auto n = static_cast<std::size_t>(state_.motion.misses() / kSnapshotsEvery);
  if (const Snapshot& snapshot = album_.nearest(prior.T_camera_object, n); snapshot.finest == finest) {
    show(snapshot, state_);
    const Alignment found = align(snapshot);
    if (found.solved && found.score > std::max(best.score, kHopelessScore)) {
      best = found;
      return;
    }
  }
  const Snapshot& nearest = album_.nearest(prior.T_camera_object, 0);
  if (nearest.finest == finest) show(nearest, state_);
}

void Pipeline::relocalize_by_outline(Alignment& best) {
  const Pose& T_last = state_.motion.pose();
  upload({0, 0, image_.camera().width, image_.camera().height}, 0);
  tried_ = state_;  // the outline leads to where pixels tell
  tried_.textured = false;
  tried_.T_snapshot.reset();
  std::vector<Alignment> starts;
  // Texture tells of other sides; beside it an outline hardly does.
  const bool all_sides = !state_.textured;
  for (const Pose& T : outline_search_.starts(T_last, state_.colors, tuning_.recovery_budget_ms, all_sides)) {
    Alignment start = aligner_.align(T, coarse_plan(aligner_.contour().coarsest(T, state_.finest)), tried_);
    if (start.solved) starts.push_back(std::move(start));
  }
  if (starts.empty()) return;
  std::ranges::stable_sort(starts, std::greater{}, &Alignment::score);
  const Pose& T_best = starts[0].T_camera_object;
  Alignment found =
      align_anywhere(T_best, std::min(state_.finest + 1, aligner_.contour().coarsest(T_best, state_.finest)));
  if (!found.solved || found.score <= best.score) return;
  if (!outline_leads(state_) && !shows_print(found)) return;
  if (is_probable(found, context(found, state_))) tell_apart(found);
  best = found;
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
    const Alignment nearest = align_anywhere(T_nearest, state_.finest);
    if (nearest.solved) found = nearest;
  }
  found.mistakable = turn(found.T_camera_object) > kMistakableTurn;
}

}  // namespace holdfast
