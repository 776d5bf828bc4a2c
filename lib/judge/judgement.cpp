#include "judge/judgement.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "solve/covariance.hpp"

namespace holdfast {
namespace {

/// What it takes to be found again after a loss, where it may be expected: share of gradient pixels used and
/// correlation; or less of it, behind an occluder, that agrees better.
constexpr double kFoundShare = 0.4, kFoundCorrelation = 0.85;
constexpr double kFoundPartShare = 0.3, kFoundPartCorrelation = 0.96;
/// Or few pixels, that agree very well and tell the pose (object radii and radians, standard deviations). Where the
/// object is expected, what is wrong but agrees as well leaves a turn open; elsewhere another part of it may look like
/// this one, and be as sure.
constexpr double kPartPixels = 300, kPartCorrelation = 0.98, kPartDeviation = 0.03, kPartTurn = 0.02;
/// What is enough anywhere: of the usual share, or less that agrees better, of the gradient pixels.
constexpr double kFoundAtOnce = 0.8, kFoundClearly = 0.5;
/// What is enough to be held on to where it was not expected; with less, fast motion was followed wrongly.
constexpr double kSurprisingShare = 0.25, kSurprisingCorrelation = 0.9;
/// The usual share where it is not known yet.
constexpr double kOrdinaryShare = 0.8;
/// What it takes to be held on to with less than `lost_visible_share`: pixels that agree very well and say of every
/// motion more than was expected anyway (object radii and radians, standard deviation; expected are 0.05).
constexpr double kSliverCorrelation = 0.95, kSliverPixels = 100, kSliverDeviation = 0.04;
/// Of fewer pixels share and correlation are chance.
constexpr double kHandful = 100;
/// Motion blur and motion that explain why a frame agrees little, pixels.
constexpr double kStrongBlur = 8, kFastMotion = 15;
/// More blur than this leaves nothing to be seen: the motion it is told from is wrong.
constexpr double kBeyondBlur = 100;
/// Standard deviation of a turn that nothing shows, radians, that is worth a word.
constexpr double kOpenTurn = 0.2;
/// Share of the usual texture that may be hidden without a word.
constexpr double kMuchHidden = 0.4;
/// Share of the texture that agrees below which that is said, whatever is usual: a wrong first pose may fit so.
constexpr double kLittleAgrees = 0.3;
/// Factor by which the light changes within a few frames that is worth a word.
constexpr double kOtherLight = 1.4;
/// Worth starting from in the next frame, though not to be believed yet: a share of the gradient pixels; or few that
/// tell the pose half as surely as would be believed.
constexpr double kPromisingShare = 0.15, kPromisingCorrelation = 0.9;
constexpr double kPromisingPixels = 200, kHalfAsSure = 2;
/// Fewer gradient pixels than this are no texture.
constexpr double kLeastGradientPixels = 20;

/// The little that is seen of an object that was held a frame ago, when it is enough.
bool is_sure_sliver(const Estimate& estimate) {
  return estimate.sums.used >= kSliverPixels && estimate.correlation >= kSliverCorrelation &&
         estimate.deviation <= kSliverDeviation;
}

/// Of few pixels that agree very well: how sure they are of the pose, beside what is enough of a part.
bool tells_pose(const Estimate& estimate, double pixels, double times_deviation) {
  return estimate.sums.used >= pixels && estimate.correlation >= kPartCorrelation &&
         estimate.deviation <= times_deviation * kPartDeviation &&
         estimate.turn_deviation() <= times_deviation * kPartTurn;
}

}  // namespace

double turn_deviation(const Matrix6& conditioned_covariance) {
  return largest_deviation(Eigen::Matrix3d(conditioned_covariance.bottomRightCorner<3, 3>()));
}

double Estimate::turn_deviation(bool that_shows) const {
  if (covariance.trace() <= 0) return std::numeric_limits<double>::infinity();
  return holdfast::turn_deviation(that_shows ? Matrix6(seen * covariance * seen.transpose()) : covariance);
}

bool is_probable(const Estimate& estimate) {
  const double share = estimate.used_share(), correlation = estimate.correlation;
  return estimate.solved && ((share >= kFoundShare && correlation >= kFoundCorrelation) ||
                             (share >= kFoundPartShare && correlation >= kFoundPartCorrelation));
}

bool is_good(const Estimate& estimate, const TrackerOptions& options, const Standing& standing) {
  if (!estimate.solved) return false;
  const double share = estimate.used_share();
  const auto is_turn_sure = [&] { return estimate.turn_deviation(standing.hides_usually) <= kSureTurn; };
  if (estimate.correlation < options.lost_correlation) return false;
  if (share < options.lost_visible_share)
    return !standing.lost_before && !standing.surprising && is_sure_sliver(estimate);
  if (!standing.lost_before) {
    if (estimate.sums.used < kHandful && !is_turn_sure()) return false;
    return !standing.surprising ||
           (is_turn_sure() &&
            (is_probable(estimate) || (share >= kSurprisingShare && estimate.correlation >= kSurprisingCorrelation)));
  }
  if (!is_turn_sure()) return false;
  const double usual_share = standing.usual_share > 0 ? standing.usual_share : kOrdinaryShare;
  const bool clear =
      share >= kFoundAtOnce * usual_share || (share >= kFoundClearly && estimate.correlation >= kFoundPartCorrelation);
  if (is_probable(estimate)) return standing.expected || clear;
  return standing.expected && tells_pose(estimate, kPartPixels, 1);
}

bool is_promising(const Estimate& estimate) {
  if (!estimate.solved) return false;
  return (estimate.used_share() >= kPromisingShare && estimate.correlation >= kPromisingCorrelation) ||
         tells_pose(estimate, kPromisingPixels, kHalfAsSure);
}

namespace {

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100 * share))) + " %"; }

/// Of the texture that is usually seen, the share that is not.
double hidden_share(const Estimate& estimate, double usual_share) {
  return usual_share > 0 ? std::clamp(1 - estimate.used_share() / usual_share, 0.0, 1.0) : 1 - estimate.used_share();
}

/// Why little of a visible object agrees with the frame.
std::string why_little_agrees(const Estimate& estimate, const Circumstances& circumstances) {
  if (circumstances.blur_pixels > kStrongBlur && circumstances.blur_pixels < kBeyondBlur) {
    return "blurred by " + std::to_string(std::lround(circumstances.blur_pixels)) + " pixels";
  }
  if (circumstances.predicted_pixels > kFastMotion) return "occluded, or motion too fast";
  return "occluded " + percent(hidden_share(estimate, circumstances.usual_share));
}

std::string why_open(const Estimate& estimate) {
  constexpr double kDegrees = 57.29577951308232;
  return "a turn does not show: known to " + std::to_string(std::lround(kDegrees * estimate.turn_deviation())) +
         " degrees (standard deviation)";
}

std::string why_it_misfits(const Proportions::Misfit& misfit) {
  char text[96];
  std::snprintf(text, sizeof text, "model at least %.1f %% too large along %c beside %c", 100 * misfit.share,
                "xyz"[misfit.large], "xyz"[misfit.small]);
  return text;
}

}  // namespace

Verdict judge(const Estimate& estimate, const TrackerOptions& options, const Circumstances& circumstances) {
  if (is_good(estimate, options, circumstances)) {
    if (hidden_share(estimate, circumstances.usual_share) > kMuchHidden && circumstances.usual_share > 0) {
      return {Status::held, why_little_agrees(estimate, circumstances)};
    }
    if (estimate.hides && estimate.turn_deviation() > kOpenTurn) return {Status::held, why_open(estimate)};
    if (circumstances.gain > kOtherLight || circumstances.gain < 1 / kOtherLight)
      return {Status::held, "light changed"};
    if (options.mode != Mode::paper && estimate.used_share() < kLittleAgrees) {
      return {Status::held,
              "only " + percent(estimate.used_share()) + " of the texture agrees: hidden, or not this pose"};
    }
    if (circumstances.misfit) return {Status::held, why_it_misfits(*circumstances.misfit)};
    return {Status::held, ""};
  }
  if (estimate.sums.visible <= 0) {
    return {Status::lost, circumstances.searched_everywhere ? "found nowhere in the picture" : "out of view"};
  }
  if (estimate.sums.gradient < kLeastGradientPixels) return {Status::lost, "no texture in view"};
  if (circumstances.lost_before && is_promising(estimate)) {
    return {Status::lost, "lost before, and not surely found again"};
  }
  if (!estimate.solved || estimate.used_share() < options.lost_visible_share) {
    return {Status::lost, why_little_agrees(estimate, circumstances)};
  }
  if (estimate.correlation < options.lost_correlation) return {Status::lost, "the frame does not look like the model"};
  if (!circumstances.lost_before) {
    return {Status::lost,
            estimate.sums.used < kHandful ? "next to no texture in view" : "occluded, or motion too fast"};
  }
  return {Status::lost, "lost before, and not surely found again"};
}

}  // namespace holdfast
