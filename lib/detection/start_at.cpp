#include <algorithm>

#include "holdfast/detection.hpp"
#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

/// Share of the texture that must agree, and its correlation with the frame; or less of it that agrees better.
constexpr double kRatio = 0.4, kCorrelation = 0.85;
constexpr double kPartRatio = 0.25, kPartCorrelation = 0.95;
constexpr int kLeastPixels = 300;
/// A guided start, whose model may have no texture, takes this score of the contour and this share of its lines with
/// the edge next to it. In frames of other scenes the score stays below 0.55 and that share below 0.8.
constexpr double kContourScore = 0.62, kNear = 0.82;
/// Lines across the model's edges that tell. A start takes less of the contour beside them, so much of both together,
/// and this score of edges: a box turned by 15 degrees has a contour of 0.87 and edges of 0.43.
constexpr double kTellingLines = 40, kContourBesideEdges = 0.5, kBoth = 1.2, kEdgeScore = 0.45;
/// Share of all this that is enough in the frames after.
constexpr double kStillSeen = 0.85;
/// Of a start by features that frames have shown: those that agree, and how far the contour may take the pose from
/// them, radians and shares of its distance.
constexpr int kLeastSeen = 15;
constexpr double kMostTurn = 0.12, kMostShare = 0.05;
/// Its contour's score at least, and share of lines with the edge next to it.
constexpr double kSeenScore = 0.45, kSeenNear = 0.7;
/// A pose is refined until it moves by less than this: radians, and shares of its distance.
constexpr int kMostRounds = 3;
constexpr double kSettledTurn = 0.01, kSettledShare = 0.003;

bool is_near(const Pose& T, const Pose& T_other, double turn, double share) {
  return rotation_angle(T.linear() * T_other.linear().transpose()) < turn &&
         (T.translation() - T_other.translation()).norm() < share * T_other.translation().norm();
}

bool is_settled(const Pose& T_before, const Pose& T_after) {
  return is_near(T_before, T_after, kSettledTurn, kSettledShare);
}

double agreement(const FrameResult& result) { return result.texture.inlier_ratio() * result.texture.correlation; }

bool is_surely_found(const FrameResult& result) {
  const TextureEvidence& texture = result.texture;
  if (result.status != Status::held || !texture.holds || texture.used_pixels < kLeastPixels) return false;
  const double ratio = texture.inlier_ratio(), correlation = texture.correlation;
  return (ratio >= kRatio && correlation >= kCorrelation) || (ratio >= kPartRatio && correlation >= kPartCorrelation);
}

/// What a guide leads to, the contour's colours learned where it is.
FrameResult refined_by_contour(Tracker& tracker, const ImageView& frame, const Pose& T_start) {
  FrameResult result = tracker.refine(frame, T_start);
  for (int round = 0; round < kMostRounds && result.status == Status::held; ++round) {
    const Pose T_before = result.T_camera_object;
    try {
      tracker.reset(T_before, frame);
    } catch (const Error&) {  // it has gone out of the picture
      result.status = Status::lost;
      break;
    }
    result = tracker.refine(frame, T_before);
    if (round > 0 && is_settled(T_before, result.T_camera_object)) break;
  }
  return result;
}

/// Colours seen where the object is not would hide it in the next frames.
void forget(Tracker& tracker, const std::vector<PoseCandidate>& candidates) {
  for (const PoseCandidate& candidate : candidates) {
    try {
      tracker.reset(candidate.T_camera_object);
      return;
    } catch (const Error&) {  // it is behind the camera or out of the picture
    }
  }
}

double fit(const FrameResult& result) { return result.contour.score() + std::max(0.0, result.edges.score); }

/// With `share` of the evidence that a start takes.
bool is_surely_found_by_contour(const FrameResult& result, double share) {
  const ContourEvidence& contour = result.contour;
  const EdgeEvidence& edges = result.edges;
  const bool fits = edges.asked && edges.lines >= kTellingLines
                        ? contour.score() >= share * kContourBesideEdges && edges.score >= share * kEdgeScore &&
                              fit(result) >= share * kBoth
                        : contour.score() >= share * kContourScore;
  return result.status == Status::held && contour.asked && fits && contour.near_lines >= share * kNear * contour.lines;
}

}  // namespace

bool is_still_seen(const FrameResult& result) {
  return is_surely_found(result) || is_surely_found_by_contour(result, kStillSeen);
}

std::optional<FrameResult> start_near(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                      const ImageView& frame, std::optional<double> time_s) {
  std::optional<FrameResult> best;
  for (const PoseCandidate& candidate : candidates) {
    const FrameResult result = refined_by_contour(tracker, frame, candidate.T_camera_object);
    const bool found = is_surely_found(result) || is_surely_found_by_contour(result, 1);
    if (found && (!best || fit(result) > fit(*best))) best = result;
  }
  if (best) {
    tracker.reset(best->T_camera_object, frame, time_s);
  } else {
    forget(tracker, candidates);
  }
  return best;
}

std::optional<FrameResult> start_seen(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                      const ImageView& frame, std::optional<double> time_s) {
  for (const PoseCandidate& candidate : candidates) {
    if (candidate.inliers < kLeastSeen) continue;
    FrameResult result = refined_by_contour(tracker, frame, candidate.T_camera_object);
    const ContourEvidence& contour = result.contour;
    if (result.status != Status::held || !contour.asked || contour.score() < kSeenScore ||
        contour.near_lines < kSeenNear * contour.lines ||
        !is_near(result.T_camera_object, candidate.T_camera_object, kMostTurn, kMostShare)) {
      continue;
    }
    tracker.reset(result.T_camera_object, frame, time_s);
    return result;
  }
  forget(tracker, candidates);
  return std::nullopt;
}

std::optional<FrameResult> start_at(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                    const ImageView& frame, std::optional<double> time_s) {
  std::optional<FrameResult> best;
  for (const PoseCandidate& candidate : candidates) {
    FrameResult result;
    result.T_camera_object = candidate.T_camera_object;
    for (int round = 0; round < kMostRounds; ++round) {
      const Pose T_before = result.T_camera_object;
      result = tracker.refine(frame, T_before);
      if (result.status != Status::held || is_settled(T_before, result.T_camera_object)) break;
    }
    if (is_surely_found(result) && (!best || agreement(result) > agreement(*best))) best = result;
  }
  if (best) tracker.reset(best->T_camera_object, frame, time_s);
  return best;
}

}  // namespace holdfast::detection
