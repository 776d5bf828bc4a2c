#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace holdfast::baking {

/// For each pixel of a mask (CV_8U, continuous) the index (row by row) of the nearest one that is 0; its own where it
/// is 0 itself, or where none is within `reach` pixels. Empty where no pixel is 0.
std::vector<std::uint32_t> nearest_zero(const cv::Mat& mask, float reach);

}  // namespace holdfast::baking
