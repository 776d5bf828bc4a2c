#include "detection/robust_pnp.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

namespace holdfast::detection {
namespace {

/// Pixels that a place may be off: views differ from frames by perspective.
constexpr float kInlierPixels = 4;
constexpr std::size_t kLeastInliers = 8;

Pose pose_of(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Mat R;
  cv::Rodrigues(rotation_vector, R);
  Pose T = Pose::Identity();
  T.linear() = Eigen::Map<const Eigen::Matrix3d>(R.ptr<double>()).transpose();  // of OpenCV's rows
  T.translation() = Eigen::Map<const Eigen::Vector3d>(translation.ptr<double>());
  return renormalized(T);
}

}  // namespace

PoseFit refined_pose(const std::vector<cv::Point3f>& places, const std::vector<cv::Point2f>& pixels, const cv::Mat& K,
                     const Pose& T_start) {
  cv::Mat R, rotation, translation;
  cv::eigen2cv(Eigen::Matrix3d(T_start.linear()), R);
  cv::eigen2cv(Eigen::Vector3d(T_start.translation()), translation);
  cv::Rodrigues(R, rotation);
  cv::solvePnPRefineLM(places, pixels, K, cv::noArray(), rotation, translation);
  std::vector<cv::Point2f> projected;
  cv::projectPoints(places, rotation, translation, K, cv::noArray(), projected);
  const double off = cv::norm(projected, pixels, cv::NORM_L2);
  return {pose_of(rotation, translation), off / std::sqrt(static_cast<double>(places.size()))};
}

std::optional<Consensus> take_consensus(Matches& matches, const cv::Mat& K) {
  if (matches.places.size() < kLeastInliers) return {};
  cv::UsacParams parameters;
  parameters.confidence = 0.999;
  parameters.maxIterations = 3000;
  parameters.threshold = kInlierPixels * matches.pixel_scale;
  parameters.sampler = cv::SAMPLING_PROSAC;
  parameters.score = cv::SCORE_METHOD_MSAC;
  parameters.loMethod = cv::LOCAL_OPTIM_INNER_LO;
  cv::Mat rotation, translation, inliers, camera_matrix = K.clone();
  const bool found = cv::solvePnPRansac(matches.places, matches.pixels, camera_matrix, cv::noArray(), rotation,
                                        translation, inliers, parameters);
  if (!found || inliers.total() < kLeastInliers) return {};
  Consensus consensus;
  std::vector<bool> agrees(matches.places.size(), false);
  for (int i = 0; i < static_cast<int>(inliers.total()); ++i) {
    const auto index = static_cast<std::size_t>(inliers.at<int>(i));
    consensus.places.push_back(matches.places[index]);
    consensus.pixels.push_back(matches.pixels[index]);
    agrees[index] = true;
  }
  Matches rest{{}, {}, matches.pixel_scale};
  for (std::size_t i = 0; i < agrees.size(); ++i) {
    if (agrees[i]) continue;
    rest.places.push_back(matches.places[i]);
    rest.pixels.push_back(matches.pixels[i]);
  }
  matches = std::move(rest);
  consensus.T_camera_object = pose_of(rotation, translation);
  return consensus;
}

}  // namespace holdfast::detection
