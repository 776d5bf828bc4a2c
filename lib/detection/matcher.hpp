#pragma once

#include <opencv2/core.hpp>
#include <opencv2/flann.hpp>
#include <vector>

#include "detection/feature_data.hpp"
#include "holdfast/image_view.hpp"

namespace holdfast::detection {

/// Features of a frame and where on the model they may be, the surest first.
struct Matches {
  std::vector<cv::Point3f> places;  ///< object frame, metres
  std::vector<cv::Point2f> pixels;
  double pixel_scale =
      1;  ///< pixels of the frame a pixel that was looked at: large frames are looked at as smaller ones
};

/// Finds a model's features in frames.
class Matcher {
 public:
  explicit Matcher(const ModelFeatures& model);

  /// Pixels as recorded, with lens distortion.
  Matches match(const ImageView& frame);

 private:
  ModelFeatures model_;
  cv::Mat descriptors_;
  cv::flann::Index trees_;
};

}  // namespace holdfast::detection
