#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common_options.hpp"

namespace holdfast::app {

/// The pose of the object near a guide, as one frame shows it; nothing where it is not seen. Throws as
/// detection::GuideDetector.
std::optional<Pose> pose_near(const Pose& T_guide, const Mesh& mesh, const Camera& camera,
                              const DeviceArguments& device, const cv::Mat& frame);

/// A doubt, in one sentence, about a guide that fills the picture with the object: its outline is what is looked for.
std::optional<std::string> guide_doubt(const Pose& T_guide, const Mesh& mesh, const Camera& camera);

/// The frame with the guide's contour (orange) and, where it was found, the object's (green).
cv::Mat guide_picture(const Pose& T_guide, const std::optional<Pose>& T_camera_object, const Mesh& mesh,
                      const Camera& camera, const cv::Mat& frame);

}  // namespace holdfast::app
