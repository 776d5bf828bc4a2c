#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

namespace holdfast::baking {

/// A frame at falling sizes, so that one look-up covers as many pixels as a texel does.
class FramePyramid {
 public:
  /// BGR8; not copied.
  explicit FramePyramid(const cv::Mat& bgr);

  /// Bilinear colour, BGR, where one sample stands for `footprint` pixels of the frame in width; u, v: pixels of the
  /// frame, inside it.
  std::array<float, 3> sample(float u, float v, float footprint);

 private:
  std::vector<cv::Mat> levels_;  // each half the size of the one before
};

}  // namespace holdfast::baking
