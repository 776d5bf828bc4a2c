// What the pipeline learns from a frame.
#include <algorithm>
#include <cmath>
#include <utility>

#include "solve/covariance.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {
namespace {

/// Weights of a new frame: in scores, in the usual inlier ratio, in shares of information.
constexpr double kTextureMemory = 0.5, kRatioMemory = 0.02, kTrustMemory = 0.1, kContourMemory = 0.1;
/// Frames between learning the contour's colours where texture leads; misses after which they are of other
/// surroundings.
constexpr int kColorsEvery = 8, kMostContourMisses = 3;
/// Share of the view's gradients that light may make to be drawn, and what of that it must be below to be drawn again.
constexpr double kMostLight = 0.2, kAgain = 0.7;
/// Light from one side that is not worth drawing.
constexpr double kLeastDirection = 0.02;
/// Pixels between the view drawn last and the pose, for light to be learned from it.
constexpr double kSameView = 2;
/// How texels are averaged is measured in the first frames and then in one of so many once it is clear; of how many
/// measurements evidence is a mean, what it must be to change the choice, and to be clear.
constexpr int kFirstMeasurements = 2, kTexelMemory = 8, kTexelPause = 64;
constexpr double kFullyConverged = 0.02, kBetterEvidence = 0.01, kClearEvidence = 0.03;
/// Reliability of a snapshot that is found; turn (radians), change of distance (logarithm) and frames in which it is
/// not found, after which another is taken.
constexpr double kFoundSnapshot = 0.02, kAnotherTurn = 0.2, kAnotherNearer = 0.1;
constexpr int kMostSnapshotMisses = 5;
/// Share of a snapshot's pixels that must be seen for another to be as sure.
constexpr double kMostlySeen = 0.5;
/// Share of the lines across edges that must see one for a first pose to be taken at its word.
constexpr double kMostlyCoherent = 0.45;
/// Share of the edges that an aligned pose finds, below which the given one is not what was meant.
constexpr double kAsManyEdges = 0.5;
/// Mean reliability of texture below which frames do not show it (clay 0.01, brushed metal 0.1, a label of 20 %
/// contrast, blurred, 0.2 to 0.3), of how many frames at least and at most.
constexpr double kUnlike = 0.12;
constexpr int kFewestLikenesses = 2, kMostLikenesses = 10;
/// Standard deviation of a turn, radians, that the outline says next to nothing of.
constexpr double kTurnKnown = 0.2;

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

void Pipeline::see(const Pose& T_camera_object, Given given, TrackingState& state) {
  const bool exact = given == Given::exactly;
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return;
  upload(object, std::max(aligner_.contour().margin(), ImageFilter::kMargin << state.finest));
  Alignment seen;
  seen.T_camera_object = T_camera_object;
  seen.imaging = state.imaging;
  if (state.textured) {
    image_.enqueue_blur(state.finest, coarser(grown(object, ImageFilter::kMargin << state.finest), state.finest));
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
    ContourModality& contour = aligner_.contour();
    // Beside a pose that is far off, colours of the finest level speak for it: lines reach half as far there.
    const int coarse = std::min(state.finest + 1, contour.coarsest(T_camera_object, state.finest));
    const int level = given == Given::roughly ? coarse : state.finest;
    state.colors.clear();
    if (contour.learn(T_camera_object, level, state.colors)) {
      contour.use_colors(state.colors);
    }
    if (exact && state.colors.known()) {
      seen.contour = contour.linearize(T_camera_object, state.finest, kClosestSearch);
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

std::optional<Pose> Pipeline::start_as_given(const Pose& T_given, const Pose& T_aligned) {
  EdgeModality& edges = aligner_.edges();
  if (!tuning_.edges || !tuning_.contour || tuning_.paper() || !edges.has_edges()) return {};
  const auto score = [&](const Pose& pose) {
    return edges.linearize(pose, state_.finest, kClosestEdgeSearch, edges.no_memory()).score();
  };
  const Pose& T_start = score(T_given) < kAsManyEdges * score(T_aligned) ? T_aligned : T_given;
  const int level = std::min(state_.finest + 1, aligner_.contour().coarsest(T_start, state_.finest));
  if (edges.coherence(T_start, level) < kMostlyCoherent) return {};
  state_.edges = edges.no_memory();
  state_.edges.off_model = true;
  edges.learn(T_start, state_.finest, state_.edges);
  see(T_start, Given::exactly, state_);
  return T_start;
}

void Pipeline::learn_usual(const Alignment& alignment, bool first, TrackingState& state) const {
  UsualEvidence& usual = state.usual;
  if (alignment.has_texture) {
    const double score = alignment.texture.score(), ratio = alignment.texture.inlier_ratio();
    usual.texture_score += (usual.texture_score > 0 ? kTextureMemory : 1) * (score - usual.texture_score);
    // What is seen when nothing is in front: rises at once, falls slowly.
    const double gradients = alignment.texture.sums.gradient * alignment.texture.row_stride;
    // The light of single cells, as learned in a first frame, fits any texture to the next.
    if (usual.held_frames > 0 && gradients >= kFewGradients) {
      usual.likeness_frames = std::min(usual.likeness_frames + 1, kMostLikenesses);
      usual.likeness += (alignment.texture.reliability - usual.likeness) / usual.likeness_frames;
    }
    usual.inlier_ratio = std::max(ratio, usual.inlier_ratio + kRatioMemory * (ratio - usual.inlier_ratio));
  }
  if (alignment.has_contour) {
    const double score = std::max(0.0, alignment.contour.score());
    const double near = near_share(alignment);
    const bool hidden = near < kMostNear * usual.contour_near;
    const double weight = usual.contour_score <= 0 ? 1.0
                          : hidden                 ? kRatioMemory
                                   : std::max(kContourMemory, 1.0 / (2 + std::max(0, usual.held_frames)));
    usual.contour_score += weight * (score - usual.contour_score);
    usual.contour_near += weight * (near - usual.contour_near);
    usual.contour_information = alignment.contour.equations.A;
  }
  const double outline = usual.contour_information.trace();
  if (alignment.has_edges) {
    const double score = std::max(0.0, alignment.edges.score());
    const bool hidden = alignment.has_contour && near_share(alignment) < kMostNear * usual.contour_near;
    usual.edge_score += (usual.edge_score <= 0 ? 1
                         : hidden              ? kRatioMemory
                                               : kContourMemory) *
                        (score - usual.edge_score);
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

void Pipeline::leave_texture(const Alignment& alignment) {
  const UsualEvidence& usual = state_.usual;
  if (!state_.textured || tuning_.paper() || !tuning_.contour) return;
  if (usual.likeness_frames < kFewestLikenesses || usual.likeness > kUnlike) return;
  // Texture that does not fit may be turned, where the outline tells nothing of a turn.
  const Matrix6 covariance = symmetric_inverse(aligner_.outline_alone(alignment).A + Matrix6::Identity());
  if (largest_deviation(Eigen::Matrix3d(covariance.bottomRightCorner<3, 3>())) > kTurnKnown) return;
  state_.textured = state_.left_unobservable = false;
  state_.gradient_pixels = 0;
  state_.usual.texture_trust = 0;
  state_.T_snapshot.reset();
}

void Pipeline::doubt_texture(Alignment& best) {
  if (!state_.textured || album_.empty() || state_.motion.lost()) return;
  if (state_.usual.likeness_frames >= kMostLikenesses || best.texture.reliability > kUnlike) return;
  const Snapshot& snapshot = album_.nearest(prior_.T_camera_object, 0);
  if (snapshot.finest != state_.finest) return;
  tried_ = state_;
  tried_.textured = false;
  tried_.usual.texture_trust = 0;
  show(snapshot, tried_);
  const Alignment without = follow_fully({prior_.T_camera_object}, false, tried_);
  if (!held(without, tried_) || !is_as_in_snapshot(without)) {
    view_.clear();  // it shows the snapshot
    return;
  }
  const Alignment with = aligner_.align(without.T_camera_object, fine_plan(state_.finest, state_), state_);
  if (held(with)) best = with;
}

void Pipeline::show(const Snapshot& snapshot, TrackingState& state) {
  view_.enqueue_snapshot(snapshot, static_cast<int>(levels_.size()) - state.finest);
  state.T_snapshot = snapshot.T_camera_object;
  state.bare_snapshot = false;
  state.sure_snapshot = snapshot.sure;
  state.imaging.texture.light = {};
}

void Pipeline::learn_contour(const Alignment& alignment) {
  if (!tuning_.contour || tuning_.paper()) return;
  UsualEvidence& usual = state_.usual;
  const AcceptanceContext context = this->context(alignment, state_);
  const bool by_texture = is_held_by_texture(alignment, context);
  const bool texture_as_usual = by_texture && alignment.texture.inlier_ratio() > kUsualShare * usual.inlier_ratio;
  ++state_.frames_since_colors;
  bool learns = false;
  if (alignment.has_contour) {
    // Colours that change with the light must be learned as long as edges are where they should be, or pixels inside
    // are what they were.
    const bool fits = near_share(alignment) > kMostNear ||
                      alignment.contour.score() > kUsualShare * usual.expected_contour_score() ||
                      (state_.sure_snapshot && is_as_in_snapshot(alignment));
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
  const std::span<const LitPatch> patches =
      lit_patches_.read(view_, aligner_.texture().constraints(), state.finest,
                        std::max(1, alignment.texture.row_stride), photometry, before);
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
    plan.converged = kFullyConverged;
    const ConstraintSums sums = aligner_.align(alignment.T_camera_object, plan, tried).texture.sums;
    return sums.rows >= 6 ? sums.weighted_square / std::max(1.0, sums.weight) : 0;
  };
  const double encoded = left_over(false), light = left_over(true);
  if (encoded <= 0 || light <= 0) return;
  texels.measured = std::min(texels.measured + 1, kTexelMemory);
  texels.evidence += (0.5 * std::log(encoded / light) - texels.evidence) / texels.measured;
  texels.light = texels.evidence > (texels.light ? -kBetterEvidence : kBetterEvidence);
}

void Pipeline::learn_snapshot(const Alignment& alignment) {
  if (!tuning_.snapshot || !tuning_.contour || tuning_.paper()) return;
  if (state_.textured && (!album_.empty() || state_.usual.held_frames > 0)) return;
  if (state_.edges.off_model) return;  // pixels turn with the object's shape, not with the model's
  state_.usual.outline_information = aligner_.outline_equations(alignment, state_).A;
  const Pose& T = alignment.T_camera_object;
  bool due = !state_.T_snapshot;
  if (!due) {
    Pose& T_snapshot = *state_.T_snapshot;
    if (alignment.has_snapshot) {
      state_.bare_snapshot = is_bare(alignment.snapshot);
      const bool found = alignment.snapshot.reliability > kFoundSnapshot;
      state_.snapshot_misses = found || state_.bare_snapshot ? 0 : state_.snapshot_misses + 1;
      if (found) T_snapshot = perturbed(T_snapshot, alignment.snapshot_shift, extent_);
      view_.set_pose(T_snapshot);
    }
    const double nearer = std::log((T * extent_.p_object_center).z() / (T_snapshot * extent_.p_object_center).z());
    due = state_.snapshot_misses >= kMostSnapshotMisses || std::abs(nearer) > kAnotherNearer ||
          rotation_angle(T.linear() * T_snapshot.linear().transpose()) > kAnotherTurn;
  }
  const AcceptanceContext context = this->context(alignment, state_);
  state_.without_outline = is_held_by_contour(alignment, context) ? 0 : state_.without_outline + 1;
  // Where something hides the outline, and the one before is not surely found, it may be of what is in front.
  const bool clear = shows_all(alignment, context.usual_outline);
  if (!due && !(clear && !state_.sure_snapshot)) return;
  state_.sure_snapshot =
      clear || (alignment.snapshot.inlier_ratio() > kMostlySeen && is_held_by_snapshot(alignment, context));
  upload(view_.bounds(T), ImageFilter::kMargin << (static_cast<int>(levels_.size()) - 1));
  if (!aligner_.take_snapshot(T, state_)) return;
  state_.T_snapshot = T;
  state_.bare_snapshot = false;
  state_.snapshot_misses = 0;
  if (!state_.textured) state_.imaging.texture.light = {};
  Snapshot snapshot = view_.read_snapshot();
  snapshot.sure = state_.sure_snapshot;
  album_.add(std::move(snapshot));
}

}  // namespace holdfast
