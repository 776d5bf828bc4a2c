#include "judgement.hpp"

#include <algorithm>

namespace holdfast {
namespace {

/// What it takes to be found again after a loss: share of gradient pixels used, correlation.
constexpr double kFoundShare = 0.4, kFoundCorrelation = 0.85;
/// Fewer gradient pixels than this are no texture.
constexpr double kLeastGradientPixels = 20;

}  // namespace

bool is_good(const Estimate& estimate, const TrackerOptions& options, bool lost_before) {
  return estimate.solved && estimate.used_share() >= (lost_before ? kFoundShare : options.lost_visible_share) &&
         estimate.correlation >= (lost_before ? kFoundCorrelation : options.lost_correlation);
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
