#pragma once

#include <opencv2/core.hpp>

#include "baking/outline_guard.hpp"

namespace holdfast::app {

/// The guard's first pose in this frame; says how far that is from the given one, unless `quiet`. Warns where the
/// outline is not clear, and keeps the given one.
Pose start_by_outline(baking::OutlineGuard& guard, const cv::Mat& frame, const Pose& T_camera_object, bool quiet);

}  // namespace holdfast::app
