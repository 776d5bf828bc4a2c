#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "common_options.hpp"

namespace holdfast::app {

/// The pose of the object near a guide, as one frame shows it; nothing where it is not seen. Throws as
/// detection::GuideDetector.
std::optional<Pose> pose_near(const Pose& T_guide, const Mesh& mesh, const Camera& camera,
                              const DeviceArguments& device, const cv::Mat& frame);

/// The frame with the guide's contour (orange) and, where it was found, the object's (green).
cv::Mat guide_picture(const Pose& T_guide, const std::optional<Pose>& T_camera_object, const Mesh& mesh,
                      const Camera& camera, const cv::Mat& frame);

}  // namespace holdfast::app
