#include "baking/frame_pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace holdfast::baking {

FramePyramid::FramePyramid(const cv::Mat& bgr) : levels_{bgr} {}

std::array<float, 3> FramePyramid::sample(float u, float v, float footprint) {
  std::size_t level = 0;
  for (float size = footprint; size > 1.5F; size /= 2) {
    if (level + 1 == levels_.size()) {
      const cv::Mat& last = levels_.back();
      if (last.cols < 2 || last.rows < 2) {
        break;
      }
      cv::Mat half;
      cv::resize(last, half, {last.cols / 2, last.rows / 2}, 0, 0, cv::INTER_AREA);
      levels_.push_back(half);
    }
    ++level;
  }
  const cv::Mat& image = levels_[level];
  // Pixel centres are at integers; the borders of all levels coincide at -0.5.
  const float x = std::clamp((u + 0.5F) * static_cast<float>(image.cols) / static_cast<float>(levels_[0].cols) - 0.5F,
                             0.0F, static_cast<float>(image.cols - 1));
  const float y = std::clamp((v + 0.5F) * static_cast<float>(image.rows) / static_cast<float>(levels_[0].rows) - 0.5F,
                             0.0F, static_cast<float>(image.rows - 1));
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.cols - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.rows - 2));
  const float ax = x - static_cast<float>(x0);
  const float ay = y - static_cast<float>(y0);
  const int right = image.cols > 1 ? 3 : 0;
  const std::uint8_t* upper = image.ptr(y0) + 3 * static_cast<std::ptrdiff_t>(x0);
  const std::uint8_t* lower = image.ptr(std::min(y0 + 1, image.rows - 1)) + 3 * static_cast<std::ptrdiff_t>(x0);
  std::array<float, 3> color{};
  for (int c = 0; c < 3; ++c) {
    const float above = static_cast<float>(upper[c]) * (1 - ax) + static_cast<float>(upper[c + right]) * ax;
    const float below = static_cast<float>(lower[c]) * (1 - ax) + static_cast<float>(lower[c + right]) * ax;
    color[static_cast<std::size_t>(c)] = above * (1 - ay) + below * ay;
  }
  return color;
}

}  // namespace holdfast::baking
