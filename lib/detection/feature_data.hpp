#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "holdfast/detection.hpp"

namespace holdfast::detection {

struct ModelFeatures::Data {
  std::string hash;   ///< model_hash()
  double radius = 0;  ///< of the mesh, metres
  std::vector<Eigen::Vector3f> p_object;
  cv::Mat descriptors;  ///< a row a feature, SIFT's 128 bytes

  /// A feature of this row, seen at this pixel and depth.
  void add(const cv::Mat& descriptor, const cv::Point2f& pixel, double z, const Camera& camera,
           const Pose& T_object_camera) {
    const Eigen::Vector3d p_camera((pixel.x - camera.cx) / camera.fx * z, (pixel.y - camera.cy) / camera.fy * z, z);
    p_object.push_back((T_object_camera * p_camera).cast<float>());
    descriptors.push_back(descriptor);
  }
};

/// Features of a picture, grey8.
struct PictureFeatures {
  std::vector<cv::KeyPoint> places;
  cv::Mat descriptors;  ///< bytes
};
PictureFeatures features_of(const cv::Mat& grey, int most);

/// Descriptors as they are compared, floats: square roots of shares (RootSIFT), whose Euclidean distance is
/// Hellinger's.
cv::Mat comparable(const cv::Mat& descriptors);

}  // namespace holdfast::detection
