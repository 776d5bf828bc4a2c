#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/image_view.hpp"

namespace holdfast::detection {

/// The frame's brightness, one byte a pixel; a view of the frame's memory where it has just that.
cv::Mat grey_of(const ImageView& frame);
/// The frame's colours (three channels in any order), or its brightness where it has no more.
cv::Mat channels_of(const ImageView& frame);

/// Throws Error(image) for a frame of another size than the camera's.
void require_size(const ImageView& frame, const Camera& camera);

/// Pixels of a recorded frame become those of the ideal pinhole image.
void undistort(const Camera& camera, std::vector<cv::Point2f>& pixels);

}  // namespace holdfast::detection
