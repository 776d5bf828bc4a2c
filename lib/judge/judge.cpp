#include "judge/judge.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Standard deviation of the orientation, radians, up to which a pose is believed: twice this is less than 5 degrees.
constexpr double kSureTurn = 0.04;
/// The same where a pose is held by the outline of an object that its texture says little of: 5 degrees.
constexpr double kKnownTurn = 0.087;
/// Standard deviation of the place, object radii, up to which an outline alone holds it.
constexpr double kKnownPlace = 0.15;
/// Share of the texture's information that must be believed.
constexpr double kLeastReliability = 0.2;
/// Few pixels that agree very well and tell the pose: enough to be held on to.
constexpr double kSliverCorrelation = 0.95, kSliverPixels = 100, kSliverDeviation = 0.04;
/// Fewer used pixels must at least tell the orientation.
constexpr double kHandful = 100;
/// To be held where it was not expected.
constexpr double kSurprisingRatio = 0.25, kSurprisingCorrelation = 0.9;
/// To be found again after a loss: inlier ratio and correlation, or less of it that agrees better.
constexpr double kFoundRatio = 0.4, kFoundCorrelation = 0.85;
constexpr double kFoundPartRatio = 0.3, kFoundPartCorrelation = 0.96;
/// To be found again anywhere: of the usual ratio, or of all with a better correlation.
constexpr double kFoundAtOnce = 0.8, kFoundClearly = 0.5, kOrdinaryRatio = 0.8;
/// Few pixels that agree very well and tell the pose, where it is expected.
constexpr double kPartPixels = 300, kPartCorrelation = 0.98, kPartDeviation = 0.03, kPartTurn = 0.02;
/// Worth starting from in the next frame.
constexpr double kPromisingContour = 0.4;
constexpr double kPromisingRatio = 0.15, kPromisingCorrelation = 0.9, kPromisingPixels = 200;
/// Share of the usual contour score that is enough at first, to be held on to, and to be found again.
constexpr double kFirstContour = 0.6, kHeldContour = 0.45, kFoundContour = 0.65;
/// Usual contour score above which colours tell what is hidden.
constexpr double kTellingScore = 0.3;
/// Reliability of a snapshot that holds the object, and how many frames in a row it may do so where the outline does
/// not show it.
constexpr double kSureSnapshot = 0.45;
constexpr int kMostWithoutOutline = 10;
/// Share of the usual score where nothing hides the outline and colours tell nothing.
constexpr double kUsualOutline = 0.8;
/// Usual share of the lines whose edge is next to the contour that must be found again.
constexpr double kFoundNear = 0.87;
/// The same where texture usually tells the pose and does not now, and pixels inside the contour.
constexpr double kHeldContourAlone = 0.7, kFoundContourAlone = 0.85;
constexpr int kLeastPixelsAlone = 1000;
/// What is worth a word: share hidden of texture and of contour, texture that agrees, other light.
constexpr double kMuchHidden = 0.4, kMuchContourHidden = 0.25, kLittleAgrees = 0.3, kOtherLight = 1.4;
constexpr double kStrongBlur = 8, kFastMotion = 15, kBeyondBlur = 100;
constexpr double kLeastGradientPixels = 20;
/// Standard deviation of a turn that nothing shows, radians, that is worth a word.
constexpr double kOpenTurn = 0.2;

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100 * share))) + " %"; }

/// Degrees.
std::string turn(const Alignment& a) {
  constexpr double kDegrees = 57.29577951308232;
  return std::to_string(std::lround(kDegrees * a.turn_deviation()));
}

bool tells_pose(const Alignment& a, double least_pixels, double times_deviation) {
  return a.texture.sums.used >= least_pixels && a.texture.correlation >= kPartCorrelation &&
         a.deviation() <= times_deviation * kPartDeviation && a.turn_deviation() <= times_deviation * kPartTurn;
}

double hidden_share(const Alignment& a, const AcceptanceContext& context) {
  const double usual = context.usual_inlier_ratio > 0 ? context.usual_inlier_ratio : 1;
  return std::clamp(1 - a.texture.inlier_ratio() / usual, 0.0, 1.0);
}

Verdict why_texture_is_weak(const Alignment& a, const AcceptanceContext& context, Status status) {
  if (context.blur_pixels > kStrongBlur && context.blur_pixels < kBeyondBlur) {
    return {status, Reason::too_fast, "blurred by " + std::to_string(std::lround(context.blur_pixels)) + " pixels"};
  }
  if (context.predicted_pixels > kFastMotion) return {status, Reason::too_fast, "occluded, or motion too fast"};
  return {status, Reason::occluded, "occluded " + percent(hidden_share(a, context))};
}

Verdict open_turn(const Alignment& a) {
  return {Status::held, Reason::ambiguous,
          "a turn does not show: known to " + turn(a) + " degrees (standard deviation)"};
}

Verdict held(const Alignment& a, const Tuning& tuning, const AcceptanceContext& context) {
  if (!is_held_by_texture(a, context)) {
    const double hidden = a.has_contour ? 1 - near_share(a) : 0;
    if (hidden > kMuchContourHidden) {
      return {Status::held, Reason::occluded, "contour hidden " + percent(hidden)};
    }
    return a.turn_deviation() > kOpenTurn ? open_turn(a) : Verdict{Status::held, Reason::none, ""};
  }
  if (context.usual_inlier_ratio > 0 && hidden_share(a, context) > kMuchHidden) {
    return why_texture_is_weak(a, context, Status::held);
  }
  if (a.texture.unobservable.count > 0 && a.turn_deviation() > kOpenTurn) {
    return open_turn(a);
  }
  if (context.gain > kOtherLight || context.gain < 1 / kOtherLight) {
    return {Status::held, Reason::light_changed, "light changed"};
  }
  if (!tuning.paper() && a.texture.inlier_ratio() < kLittleAgrees) {
    return {Status::held, Reason::low_evidence,
            "only " + percent(a.texture.inlier_ratio()) + " of the texture agrees: hidden, or not this pose"};
  }
  return {Status::held, Reason::none, ""};
}

Verdict not_found_again(const Alignment& a, const AcceptanceContext& context) {
  if (is_promising(a, context) || outline_score(a, context.usual_outline) >= kPromisingContour) {
    return {Status::lost, Reason::not_surely_found, "lost before, and not surely found again"};
  }
  return {Status::lost, Reason::out_of_view, "lost before, and not found again yet"};
}

Verdict lost_by_contour(const Alignment& a, const AcceptanceContext& context) {
  if (a.contour.visible_pixels <= 0 && !a.contour.found) return {Status::lost, Reason::out_of_view, "out of view"};
  if (!a.contour.found) {
    return {Status::lost, Reason::out_of_view, "too little of the contour in view"};
  }
  if (a.contour.sums.rows < 6) {
    return {Status::lost, Reason::no_evidence,
            "the contour is not found: nothing there stands out from its background"};
  }
  if (a.mistakable) {
    return {Status::lost, Reason::ambiguous, "seen, but another pose of this shape fits as well"};
  }
  if (context.lost_before) return not_found_again(a, context);
  if (a.has_texture && a.texture.sums.gradient >= kHandful && a.turn_deviation() > kKnownTurn &&
      outline_score(a, context.usual_outline) >= kHeldContour) {
    return {Status::lost, Reason::ambiguous,
            "its outline is seen, but not how it is turned: known to " + turn(a) + " degrees (standard deviation)"};
  }
  if (!context.expected) {
    return {Status::lost, Reason::ambiguous, "the contour fits only where the object could hardly have come to"};
  }
  return {Status::lost, Reason::occluded, "the contour is not found: occluded, or motion too fast"};
}

bool is_probable_by_texture(const Alignment& a) {
  const double ratio = a.texture.inlier_ratio(), correlation = a.texture.correlation;
  return a.solved && a.has_texture &&
         ((ratio >= kFoundRatio && correlation >= kFoundCorrelation) ||
          (ratio >= kFoundPartRatio && correlation >= kFoundPartCorrelation));
}

/// Contour and edges together show the object, by this share of what is usual.
bool shows_outline(const Alignment& a, const AcceptanceContext& context, double share) {
  const UsualOutline& usual = context.usual_outline;
  if (outline_score(a, usual) < share) return false;
  // What is left of a long thing at the picture's border tells next to nothing of where it is along itself.
  if (!a.has_texture && a.place_deviation() > kKnownPlace) return false;
  // Where the model has a texture to tell turns by, one that neither texture nor outline show is not known; but a first
  // pose is given.
  if (!context.first && a.has_texture && a.texture.sums.gradient >= kHandful && a.turn_deviation() > kKnownTurn)
    return false;
  if (context.texture_trust <= kTextureLeads) return true;
  const double turn = context.unobservable_usually ? a.observable_turn_deviation() : a.turn_deviation();
  return a.contour.visible_pixels >= kLeastPixelsAlone && !context.jumps && turn <= kSureTurn;
}

/// Whether they show it so well that it is found again.
bool is_probable_by_outline(const Alignment& a, const AcceptanceContext& context) {
  if (a.mistakable || !a.solved || !(a.has_contour || a.has_edges)) return false;
  if (a.has_contour && near_share(a) < kFoundNear * context.usual_outline.near) return false;
  const bool alone = context.texture_trust > kTextureLeads || !context.near;
  return shows_outline(a, context, alone ? kFoundContourAlone : kFoundContour);
}

}  // namespace

bool is_held_by_texture(const Alignment& a, const AcceptanceContext& context) {
  if (!a.solved || !a.has_texture || a.texture.sums.gradient < kLeastGradientPixels) return false;
  const TextureTerms& texture = a.texture;
  const double ratio = texture.inlier_ratio(), correlation = texture.correlation;
  const double turn = context.unobservable_usually ? a.observable_turn_deviation() : a.turn_deviation();
  const bool sure_turn = turn <= kSureTurn;
  if (ratio < context.least_ratio || texture.reliability < kLeastReliability) {
    return ratio < context.least_ratio && !context.lost_before && !context.surprising &&
           texture.sums.used >= kSliverPixels && correlation >= kSliverCorrelation && a.deviation() <= kSliverDeviation;
  }
  if (!context.lost_before) {
    if (texture.sums.used < kHandful && !sure_turn) return false;
    return !context.surprising || (sure_turn && (is_probable_by_texture(a) ||
                                                 (ratio >= kSurprisingRatio && correlation >= kSurprisingCorrelation)));
  }
  if (!sure_turn) return false;
  const double usual = context.usual_inlier_ratio > 0 ? context.usual_inlier_ratio : kOrdinaryRatio;
  const bool clear = ratio >= kFoundAtOnce * usual || (ratio >= kFoundClearly && correlation >= kFoundPartCorrelation);
  if (is_probable_by_texture(a)) return context.expected || clear;
  return context.expected && tells_pose(a, kPartPixels, 1);
}

bool is_held_by_contour(const Alignment& a, const AcceptanceContext& context) {
  if (!a.solved || !(a.has_contour || a.has_edges) || !context.expected) return false;
  // Far from where it was expected it must be found again.
  if (context.lost_before || context.jumps) return is_probable_by_outline(a, context);
  const double least = context.first ? kFirstContour : kHeldContour;
  // Edges alone lead a first pose to any others of the frame.
  if (context.first && a.has_contour && contour_evidence(a, context.usual_outline) < kFirstContour) return false;
  return shows_outline(a, context, context.texture_trust > kTextureLeads ? kHeldContourAlone : least);
}

bool is_held_by_snapshot(const Alignment& a, const AcceptanceContext& context) {
  if (!a.solved || !a.has_snapshot || !context.sure_snapshot) return false;
  if (a.snapshot.reliability < kSureSnapshot || a.snapshot.sums.used < kHandful || a.turn_deviation() > kSureTurn) {
    return false;
  }
  if (!context.expected) return shows_outline(a, context, kFoundContour);
  if (context.lost_before) return shows_outline(a, context, kHeldContour);
  // What lies behind an object stays as it is, too: in the long run its outline must be there.
  return outline_score(a, context.usual_outline) >= kPromisingContour || context.without_outline < kMostWithoutOutline;
}

bool is_as_in_snapshot(const Alignment& a) {
  return a.has_snapshot && texture_reliability(a.snapshot.inlier_ratio(), a.snapshot.correlation) > kSureSnapshot;
}

bool shows_all(const Alignment& a, const UsualOutline& usual) {
  if (a.has_contour && usual.contour_score > kTellingScore) return near_share(a) > kMostNear;
  return outline_score(a, usual) > kUsualOutline;
}

bool is_probable(const Alignment& a, const AcceptanceContext& context) {
  return is_probable_by_texture(a) || is_probable_by_outline(a, context);
}

bool is_held(const Alignment& a, const AcceptanceContext& context) {
  if (context.print_missing) return false;
  return is_held_by_texture(a, context) || is_held_by_contour(a, context) || is_held_by_snapshot(a, context);
}

bool may_go_on(const Alignment& a, const AcceptanceContext& context) {
  return a.solved && (a.has_contour || a.has_edges) && outline_score(a, context.usual_outline) >= kPromisingContour;
}

bool is_promising(const Alignment& a, const AcceptanceContext& context) {
  if (!a.solved) return false;
  if (context.expected && context.texture_trust <= kTextureLeads &&
      outline_score(a, context.usual_outline) >= kPromisingContour) {
    return true;
  }
  if (!a.has_texture) return false;
  return (a.texture.inlier_ratio() >= kPromisingRatio && a.texture.correlation >= kPromisingCorrelation) ||
         tells_pose(a, kPromisingPixels, 2);
}

Verdict judge(const Alignment& a, const Tuning& tuning, const AcceptanceContext& context) {
  if (is_held(a, context)) {
    if (a.undecided) return {Status::lost, Reason::ambiguous, "seen, but its mirrored tilt fits as well"};
    return held(a, tuning, context);
  }
  if (context.print_missing) {
    return {Status::lost, Reason::low_evidence,
            "its outline is seen, but the model's print is not on it: another object, or another pose"};
  }
  if (!a.has_texture || (context.texture_trust <= kTextureLeads && a.has_contour)) return lost_by_contour(a, context);
  if (a.texture.sums.visible <= 0) {
    return {Status::lost, Reason::out_of_view,
            context.searched_everywhere ? "found nowhere in the picture" : "out of view"};
  }
  if (a.texture.sums.gradient < kLeastGradientPixels) {
    return {Status::lost, Reason::no_evidence, "no texture in view"};
  }
  if (context.lost_before) return not_found_again(a, context);
  if (!a.solved || a.texture.inlier_ratio() < context.least_ratio) return why_texture_is_weak(a, context, Status::lost);
  if (a.texture.reliability < kLeastReliability) {
    return {Status::lost, Reason::low_evidence, "the frame does not look like the model"};
  }
  return {Status::lost, Reason::occluded,
          a.texture.sums.used < kHandful ? "next to no texture in view" : "occluded, or motion too fast"};
}

}  // namespace holdfast
