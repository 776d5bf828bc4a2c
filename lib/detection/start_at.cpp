#include "holdfast/detection.hpp"
#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

/// Share of the texture that must agree, and its correlation with the frame; or less of it that agrees better.
constexpr double kRatio = 0.4, kCorrelation = 0.85;
constexpr double kPartRatio = 0.25, kPartCorrelation = 0.95;
constexpr int kLeastPixels = 300;
/// A pose is refined until it moves by less than this: radians, and shares of its distance.
constexpr int kMostRounds = 3;
constexpr double kSettledTurn = 0.01, kSettledShare = 0.003;

bool is_settled(const Pose& T_before, const Pose& T_after) {
  return rotation_angle(T_before.linear() * T_after.linear().transpose()) < kSettledTurn &&
         (T_before.translation() - T_after.translation()).norm() < kSettledShare * T_after.translation().norm();
}

double agreement(const FrameResult& result) { return result.texture.inlier_ratio() * result.texture.correlation; }

bool is_surely_found(const FrameResult& result) {
  const TextureEvidence& texture = result.texture;
  if (result.status != Status::held || !texture.holds || texture.used_pixels < kLeastPixels) return false;
  const double ratio = texture.inlier_ratio(), correlation = texture.correlation;
  return (ratio >= kRatio && correlation >= kCorrelation) || (ratio >= kPartRatio && correlation >= kPartCorrelation);
}

}  // namespace

std::optional<FrameResult> start_at(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                    const ImageView& frame, std::optional<double> time_s) {
  std::optional<FrameResult> best;
  for (const PoseCandidate& candidate : candidates) {
    if (candidate.T_camera_object.translation().z() <= 0) continue;
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
