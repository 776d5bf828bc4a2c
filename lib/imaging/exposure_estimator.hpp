#pragma once

#include <functional>

#include "imaging/imaging_state.hpp"

namespace holdfast {

/// How well a view fits that is blurred by this exposure, instead as much across the motion: score and residual.
struct ExposureFit {
  double score = -1;
  double residual = 0;  ///< root of the mean weighted square
};
using FitExposure = std::function<ExposureFit(const ExposureState& exposure, bool across)>;

/// Whether the exposure is to be measured in a frame in which the object moved by so many pixels; counts the frame.
bool exposure_is_due(ExposureState& exposure, double motion_pixels);

/// Measures how long the shutter is open from how views blurred more and less fit (equation 6a of docs/math.md).
void measure_exposure(ExposureState& exposure, const FitExposure& fit);

}  // namespace holdfast
