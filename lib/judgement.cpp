#include "judgement.hpp"

#include <algorithm>

namespace holdfast {
namespace {

/// What it takes to be found again after a loss: share of gradient pixels used and correlation; or less of it, behind
/// an occluder, that agrees better.
constexpr double kFoundShare = 0.4, kFoundCorrelation = 0.85;
constexpr double kFoundPartShare = 0.3, kFoundPartCorrelation = 0.96;
/// Worth starting from in the next frame, though not to be believed yet.
constexpr double kPromisingShare = 0.15, kPromisingCorrelation = 0.9;
/// Fewer gradient pixels than this are no texture.
constexpr double kLeastGradientPixels = 20;

}  // namespace

bool is_good(const Estimate& estimate, const TrackerOptions& options, bool lost_before) {
  if (!estimate.solved) return false;
  const double share = estimate.used_share(), correlation = estimate.correlation;
  if (share < options.lost_visible_share || correlation < options.lost_correlation) return false;
  return !lost_before || (share >= kFoundShare && correlation >= kFoundCorrelation) ||
         (share >= kFoundPartShare && correlation >= kFoundPartCorrelation);
}

bool is_promising(const Estimate& estimate) {
  return estimate.solved && estimate.used_share() >= kPromisingShare && estimate.correlation >= kPromisingCorrelation;
}

Verdict judge(const Estimate& estimate, const TrackerOptions& options, bool lost_before) {
  if (estimate.sums.visible <= 0) return {Status::lost, "out of view"};
  if (estimate.sums.gradient < kLeastGradientPixels) return {Status::lost, "no texture in view"};
  if (!estimate.solved) return {Status::lost, "too few constraints left"};
  if (estimate.used_share() < options.lost_visible_share) return {Status::lost, "occluded or moved too fast"};
  if (estimate.correlation < options.lost_correlation) return {Status::lost, "the frame does not look like the model"};
  if (!is_good(estimate, options, lost_before)) return {Status::lost, "lost before, and not surely found again"};
  return {Status::held, ""};
}

}  // namespace holdfast
