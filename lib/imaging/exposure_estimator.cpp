#include "imaging/exposure_estimator.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace holdfast {
namespace {

/// Motion between frames, pixels, that shows how long the shutter is open.
constexpr double kTellingMotion = 6;
/// Steps that the exposure is searched with.
constexpr double kStep = 0.2;
/// Measurements that the exposure is a mean of, about.
constexpr int kMemory = 6;
/// Fast frames between measurements once it is known, and how often that is doubled.
constexpr int kPause = 8, kMostDoublings = 3;
/// What another exposure must score beside the present one to be believed.
constexpr double kBetter = 1.03;

}  // namespace

bool exposure_is_due(ExposureState& exposure, double motion_pixels) {
  if (motion_pixels < kTellingMotion) return false;
  // The longer it stays as it is, the more seldom it is looked at again.
  const int pause = kPause << std::clamp((exposure.settled - 3) / 2, 0, kMostDoublings);
  if (exposure.known() && ++exposure.fast_frames < pause) return false;
  exposure.fast_frames = 0;
  return true;
}

void measure_exposure(ExposureState& exposure, const FitExposure& fit) {
  const ExposureState present = exposure;
  // Where nothing blurs, less of it is the same, and so is whatever adds up.
  const bool blurred = present.share > 0;
  const auto fitted = [&](double share, bool light, bool across = false) {
    ExposureState tried = present;
    tried.share = share;
    tried.light = light;
    return fit(tried, across);
  };
  const std::array<double, 2> around{std::max(0.0, present.share - kStep), std::min(1.0, present.share + kStep)};
  std::array<ExposureFit, 2> beside;
  std::optional<ExposureFit> otherwise;
  const ExposureFit here = fitted(present.share, present.light);
  beside[1] = fitted(around[1], present.light);
  beside[0] = here;
  if (blurred) {
    beside[0] = fitted(around[0], present.light);
    otherwise = fitted(present.share, !present.light);
    const ExposureFit sharp = around[0] > 0 ? fitted(0, present.light) : beside[0];
    exposure.directions.add(sharp.score, here.score, fitted(present.share, present.light, true).score);
  }
  const bool longer = beside[1].score > kBetter * here.score;
  if (!blurred && longer) {
    exposure.directions.add(here.score, beside[1].score, fitted(around[1], present.light, true).score);
  }
  if ((blurred || longer) && !exposure.directions.along_motion()) {  // the lens, or noise
    exposure.settled = blurred ? 0 : exposure.settled + 1;
    exposure.share = 0;
    return;
  }
  const std::size_t better = beside[1].score > beside[0].score ? 1 : 0;
  // Between the three a parabola; it may have no top where one is far off.
  const double bend = 2 * here.score - beside[0].score - beside[1].score;
  const bool inside = blurred && beside[better].score <= kBetter * here.score && bend > 0.02 * here.score;
  const double top = inside ? 0.5 * kStep * (beside[1].score - beside[0].score) / bend : 0;
  if (beside[better].score > kBetter * here.score) {
    exposure.share = around[better];
    exposure.settled = 0;
  } else if (otherwise && here.residual > kBetter * otherwise->residual) {
    // Shares and correlations are the same to a hundredth, whatever adds up; what is left over tells.
    exposure.light = !exposure.light;
    exposure.settled = 0;
  } else {
    // A single frame says it roughly: the mean of some.
    const double step = std::clamp(top, -0.5 * kStep, 0.5 * kStep);
    exposure.share = std::clamp(present.share + step / (2 + std::min(exposure.settled, kMemory)), 0.0, 1.0);
    ++exposure.settled;
  }
}

}  // namespace holdfast
