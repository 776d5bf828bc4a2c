#pragma once

#include <string>

#include "holdfast/detection.hpp"
#include "video/frame_source.hpp"

namespace holdfast::app {

struct EstimatedCamera {
  Camera camera;
  double focal_sigma = 0;  ///< pixels
  int frames = 0;          ///< that it is estimated from
};

/// The camera's focal length from frames spread over a recording. Throws Error(camera) where too few show the object.
EstimatedCamera estimate_camera(const detection::ModelFeatures& features, const std::string& input,
                                const FrameSourceOptions& options, const FrameSource& source);

/// The same from a live camera's next frames.
EstimatedCamera estimate_camera(const detection::ModelFeatures& features, FrameSource& live);

}  // namespace holdfast::app
