#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "evaluation/protocol.hpp"
#include "holdfast/camera.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::evaluation {

/// What decided a pose, against where occluders are seen: `occluder` is CV_8U, 255 times a pixel's share that shows
/// one, and a pixel with half of it or more counts as one. Throws Error(image) where the sizes differ.
OccluderUse occluder_use(const PixelMask& decisions, const cv::Mat& occluder);

/// A mask file as the tracker sees the frame: without lens distortion. Throws Error(file) where it cannot be read.
cv::Mat load_occluder_mask(const std::filesystem::path& path, const Camera& camera);

}  // namespace holdfast::evaluation
