#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Steps that the exposure is searched with.
constexpr double kExposureStep = 0.2;
/// Measurements that the exposure is a mean of, about.
constexpr int kExposureMemory = 6;
/// Fast frames between measurements once it is known, and how often that is doubled.
constexpr int kExposurePause = 8, kMostDoublings = 3;
/// What another exposure must score beside the present one to be believed.
constexpr double kBetterExposure = 1.03;

}  // namespace

Tracker::Impl::Fit Tracker::Impl::fit(const Pose& T_camera_object, double exposure, bool light, bool across) {
  const Appearance before = appearance();
  look_.exposure = exposure;
  look_.exposed_light = light;
  const bool drawn = draw(T_camera_object, finest_, 1, across);
  Estimate estimate;
  if (drawn) {
    // The cells' light is each view's own: the present view's would speak for it.
    photometry_.start_level(finest_, view_.planes(finest_).tiles);
    evaluate(finest_, Pose::Identity());
    estimate.sums = sums_at(finest_, Pose::Identity());
    estimate.correlation = Photometry::correlation(constraints_);
  }
  restore(before);
  if (!drawn) return {};
  return {estimate.merit(), std::sqrt(estimate.sums.weighted_square / std::max(1.0, estimate.sums.weight))};
}

void Tracker::Impl::measure_exposure(const Estimate& estimate) {
  if (corner_motion(motion_.pose(), estimate.T_camera_object) < kTellingMotion) return;
  // The longer it stays as it is, the more seldom it is looked at again.
  const int pause = kExposurePause << std::clamp((look_.exposure_settled - Look::kSettled) / 2, 0, kMostDoublings);
  if (look_.exposure_known() && ++look_.fast_frames < pause) return;
  look_.fast_frames = 0;
  const double present = look_.exposure;
  const bool light = look_.exposed_light;
  // Where nothing blurs, less of it is the same, and so is whatever adds up.
  const bool blurred = present > 0;
  const auto fitted = [&](double exposure, bool as_light, bool across = false) {
    return fit(estimate.T_camera_object, exposure, as_light, across);
  };
  const std::array<double, 2> around{std::max(0.0, present - kExposureStep), std::min(1.0, present + kExposureStep)};
  std::array<Fit, 2> beside;
  std::optional<Fit> otherwise;
  Fit sharp, across, here;
  beside[1] = fitted(around[1], light);
  if (blurred) {
    beside[0] = fitted(around[0], light);
    otherwise = fitted(present, !light);
    sharp = around[0] > 0 ? fitted(0, light) : beside[0];
    across = fitted(present, light, true);
    here = fitted(present, light);  // whose view is left
    look_.blurred.add(sharp.score, here.score, across.score);
  } else {
    beside[0] = here = fitted(present, light);
  }
  const bool longer = beside[1].score > kBetterExposure * here.score;
  if (!blurred && longer) {
    across = fitted(around[1], light, true);
    look_.blurred.add(here.score, beside[1].score, across.score);
    here = fitted(present, light);
  }
  if ((blurred || longer) && !look_.blurred.one()) {
    // The lens, or noise: measure_lens() tells how much.
    look_.exposure_settled = blurred ? 0 : look_.exposure_settled + 1;
    look_.exposure = 0;
    return;
  }
  const std::size_t better = beside[1].score > beside[0].score ? 1 : 0;
  // Between the three a parabola; it may have no top where one is far off.
  const double bend = 2 * here.score - beside[0].score - beside[1].score;
  const bool inside = blurred && beside[better].score <= kBetterExposure * here.score && bend > 0.02 * here.score;
  const double top = inside ? 0.5 * kExposureStep * (beside[1].score - beside[0].score) / bend : 0;
  if (beside[better].score > kBetterExposure * here.score) {
    look_.exposure = around[better];
    look_.exposure_settled = 0;
  } else if (otherwise && here.residual > kBetterExposure * otherwise->residual) {
    // Shares and correlations are the same to a hundredth, whatever adds up; what is left over tells.
    look_.exposed_light = !look_.exposed_light;
    look_.exposure_settled = 0;
  } else {
    // A single frame says it roughly: the mean of some.
    const double step = std::clamp(top, -0.5 * kExposureStep, 0.5 * kExposureStep);
    look_.exposure = std::clamp(present + step / (2 + std::min(look_.exposure_settled, kExposureMemory)), 0.0, 1.0);
    ++look_.exposure_settled;
  }
}

}  // namespace holdfast
