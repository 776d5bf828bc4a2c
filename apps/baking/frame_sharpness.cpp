#include "baking/frame_sharpness.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace holdfast::baking {
namespace {

constexpr double kBlur = 1.5;  // pixels

/// Mean absolute gradients, across and down.
std::array<double, 2> gradients(const cv::Mat& grey, const cv::Mat& mask) {
  std::array<double, 2> means{};
  for (int direction = 0; direction < 2; ++direction) {
    cv::Mat gradient;
    const cv::Matx13f kernel(-1, 0, 1);
    cv::filter2D(grey, gradient, CV_32F, direction == 0 ? cv::Mat(kernel) : cv::Mat(kernel.t()));
    means[static_cast<std::size_t>(direction)] = cv::mean(cv::abs(gradient), mask)[0];
  }
  return means;
}

}  // namespace

double FrameSharpness::relative_to(const FrameSharpness& other) const {
  double worst = 1e9;
  for (std::size_t i = 0; i < 2; ++i) {
    if (other.lost[i] > 0) {
      worst = std::min(worst, lost[i] / other.lost[i]);
    }
  }
  return worst < 1e9 ? worst : 1;
}

FrameSharpness frame_sharpness(const cv::Mat& bgr, const cv::Mat& mask) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(grey, CV_32F);
  cv::Mat blurred;
  cv::GaussianBlur(grey, blurred, {}, kBlur);
  const std::array<double, 2> sharp = gradients(grey, mask);
  const std::array<double, 2> soft = gradients(blurred, mask);
  FrameSharpness result;
  for (std::size_t i = 0; i < 2; ++i) {
    result.lost[i] = soft[i] > 1e-3 ? std::max(0.0, sharp[i] / soft[i] - 1) : 0;
  }
  return result;
}

}  // namespace holdfast::baking
