#pragma once

#include <opencv2/core.hpp>

#include "holdfast/image_view.hpp"

namespace holdfast::app {

/// Whether all three channels (BGR8) say the same, up to what decoding makes of it.
bool is_monochrome(const cv::Mat& bgr);

/// A decoded frame (BGR8) as a tracker takes it. What a monochrome camera has recorded is decoded into three channels,
/// of which none looks like the same channel of a coloured model: it is viewed as the one channel that it has, which
/// `grey` holds. The view is valid as long as both are.
ImageView tracker_view(const cv::Mat& bgr, cv::Mat& grey);

}  // namespace holdfast::app
