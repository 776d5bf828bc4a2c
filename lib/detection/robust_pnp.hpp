#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/matcher.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::detection {

/// A pose fitted to matches.
struct PoseFit {
  Pose T_camera_object;
  double pixels = 0;  ///< root mean square off
};

/// Matches that agree on a pose.
struct Consensus {
  Pose T_camera_object;
  std::vector<cv::Point3f> places;
  std::vector<cv::Point2f> pixels;
};

/// The largest consensus of at least eight matches, which are taken out of `matches`; their pixels are those of a
/// pinhole camera K.
std::optional<Consensus> take_consensus(Matches& matches, const cv::Mat& K);

/// The pose of least squared distance in the picture, from `T_start` on.
PoseFit refined_pose(const std::vector<cv::Point3f>& places, const std::vector<cv::Point2f>& pixels, const cv::Mat& K,
                     const Pose& T_start);

}  // namespace holdfast::detection
