#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace holdfast::baking {

/// How much a slight blur takes from the gradients of a picture, across and down: much where it is sharp, little where
/// it is blurred (by motion, or out of focus) already. Contrast and brightness do not matter. 0 is nothing at all.
struct FrameSharpness {
  std::array<double, 2> lost{};  ///< gradients without the blur over gradients with it, less 1

  /// As a share of another picture's of the same thing, in the direction in which it is worse.
  double relative_to(const FrameSharpness& other) const;
};

/// Of the pixels where `mask` (CV_8U, of the picture's size) is not 0. `bgr`: BGR8.
FrameSharpness frame_sharpness(const cv::Mat& bgr, const cv::Mat& mask);

}  // namespace holdfast::baking
