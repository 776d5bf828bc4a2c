#include "video/tracker_view.hpp"

#include <algorithm>
#include <cstdlib>

namespace holdfast::app {
namespace {

/// What rounding between colour spaces may make of grey, of 255.
constexpr int kRounding = 2;

}  // namespace

bool is_monochrome(const cv::Mat& bgr) {
  for (int y = 0; y < bgr.rows; ++y) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(y);
    // A row of colour ends it; within one, looking at every pixel is quicker than asking after each.
    int farthest = 0;
    for (int x = 0; x < bgr.cols; ++x) {
      farthest = std::max({farthest, std::abs(row[x][0] - row[x][1]), std::abs(row[x][2] - row[x][1])});
    }
    if (farthest > kRounding) return false;
  }
  return !bgr.empty();
}

ImageView tracker_view(const cv::Mat& bgr, cv::Mat& grey) {
  if (!is_monochrome(bgr)) return {bgr.data, bgr.cols, bgr.rows, bgr.step[0], PixelFormat::bgr8};
  cv::extractChannel(bgr, grey, 1);
  return {grey.data, grey.cols, grey.rows, grey.step[0], PixelFormat::grey8};
}

}  // namespace holdfast::app
