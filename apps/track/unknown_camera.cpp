#include "track/unknown_camera.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "holdfast/error.hpp"
#include "video/tracker_view.hpp"

namespace holdfast::app {
namespace {

/// Frames that are looked at, and live ones that are left out between them.
constexpr std::int64_t kFrames = 24;
constexpr int kBetween = 9;

EstimatedCamera estimate_from(const detection::ModelFeatures& features, FrameSource& source, int between) {
  const cv::Size size = source.size();
  detection::FocalEstimator estimator(features, size.width, size.height);
  Frame frame;
  cv::Mat grey;
  std::int64_t looked_at = 0;
  while (looked_at < kFrames && source.next(frame)) {
    estimator.add(tracker_view(frame.image, grey));
    ++looked_at;
    for (int i = 0; i < between && source.next(frame); ++i) {
    }
  }
  const auto estimate = estimator.estimate();
  if (!estimate) {
    throw Error(
        ErrorCode::camera,
        fmt::format("without --camera the focal length is estimated from the object, which is seen in less than "
                    "three of {} frames: give a calibration",
                    looked_at));
  }
  EstimatedCamera result;
  result.camera = {
      size.width, size.height, estimate->focal, estimate->focal, 0.5 * (size.width - 1), 0.5 * (size.height - 1), {}};
  result.focal_sigma = estimate->sigma;
  result.frames = estimate->frames;
  return result;
}

}  // namespace

EstimatedCamera estimate_camera(const detection::ModelFeatures& features, const std::string& input,
                                const FrameSourceOptions& options, const FrameSource& source) {
  FrameSourceOptions spread = options;
  spread.stride *= std::max<std::int64_t>(1, source.frame_count().value_or(kFrames) / kFrames);
  FrameSource frames(input, spread);
  return estimate_from(features, frames, 0);
}

EstimatedCamera estimate_camera(const detection::ModelFeatures& features, FrameSource& live) {
  return estimate_from(features, live, kBetween);
}

}  // namespace holdfast::app
