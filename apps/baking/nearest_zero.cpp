#include "baking/nearest_zero.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace holdfast::baking {

std::vector<std::uint32_t> nearest_zero(const cv::Mat& mask, float reach) {
  const auto count = static_cast<std::uint32_t>(mask.total());
  if (cv::countNonZero(mask) == static_cast<int>(count)) {
    return {};
  }
  cv::Mat distance;
  cv::Mat labels;
  cv::distanceTransform(mask, distance, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  const auto* label = labels.ptr<std::int32_t>();
  std::vector<std::uint32_t> pixel_of_label;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (mask.data[i] == 0) {
      pixel_of_label.resize(std::max(pixel_of_label.size(), static_cast<std::size_t>(label[i]) + 1));
      pixel_of_label[label[i]] = i;
    }
  }
  std::vector<std::uint32_t> nearest(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    nearest[i] = distance.ptr<float>()[i] <= reach ? pixel_of_label[label[i]] : i;
  }
  return nearest;
}

}  // namespace holdfast::baking
