#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/flann.hpp>
#include <opencv2/imgproc.hpp>

#include "detection/feature_data.hpp"
#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

/// Larger frames are looked at as if they had so many pixels.
constexpr double kMostPixels = 640 * 480;
constexpr int kMostFeatures = 2000;
/// Nearest features of the model that are asked for, and how many leaves of the trees are looked at for them.
constexpr int kNeighbours = 6, kChecks = 48, kTrees = 4;
/// The nearest one must be nearer than this share of the nearest one elsewhere on the model: farther than this share of
/// its radius, since views of the same place repeat each other.
constexpr float kRatio = 0.9f;
constexpr double kElsewhere = 0.08;
/// Pixels that a place may be off: views differ from frames by perspective.
constexpr float kInlierPixels = 4;
constexpr int kLeastInliers = 8;
constexpr std::size_t kMostCandidates = 4;
/// A mirrored tilt is another pose from so many radians on, and one to look at if it is at most so many times as far
/// off.
constexpr double kOtherTurn = 0.1, kAsGood = 3;

cv::Mat grey_of(const ImageView& frame) {
  const std::size_t stride = frame.stride_bytes > 0 ? frame.stride_bytes : packed_stride(frame.format, frame.width);
  auto* bytes = const_cast<std::uint8_t*>(frame.data);
  const auto given = [&](int type) { return cv::Mat(frame.height, frame.width, type, bytes, stride); };
  cv::Mat grey;
  switch (frame.format) {
    case PixelFormat::bgr8:
      cv::cvtColor(given(CV_8UC3), grey, cv::COLOR_BGR2GRAY);
      break;
    case PixelFormat::rgb8:
      cv::cvtColor(given(CV_8UC3), grey, cv::COLOR_RGB2GRAY);
      break;
    case PixelFormat::rgba8:
      cv::cvtColor(given(CV_8UC4), grey, cv::COLOR_RGBA2GRAY);
      break;
    case PixelFormat::grey8:
    case PixelFormat::nv12:
      grey = given(CV_8UC1);
      break;
    case PixelFormat::yuyv:
      cv::extractChannel(given(CV_8UC2), grey, 0);
      break;
  }
  return grey;
}

Pose pose_of(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Mat R;
  cv::Rodrigues(rotation_vector, R);
  Pose T = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) T.linear()(row, column) = R.at<double>(row, column);
    T.translation()(row) = translation.at<double>(row);
  }
  return renormalized(T);
}

/// The other way that a face may be tilted to look the same from far away: turned about its middle so that its normal
/// lies mirrored in the line of sight.
Pose mirrored(const std::vector<cv::Point3f>& places, const Pose& T_camera_object) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    p.col(static_cast<Eigen::Index>(i)) << places[i].x, places[i].y, places[i].z;
  }
  const Eigen::Vector3d p_mean = p.rowwise().mean();
  p.colwise() -= p_mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(p * p.transpose());
  const Eigen::Vector3d p_camera = T_camera_object * p_mean, sight = p_camera.normalized();
  const Eigen::Vector3d normal = T_camera_object.linear() * axes.eigenvectors().col(0);
  const Eigen::Vector3d image = 2 * sight.dot(normal) * sight - normal;
  Pose result = T_camera_object;
  result.linear() = Eigen::Quaterniond::FromTwoVectors(normal, image).toRotationMatrix() * T_camera_object.linear();
  result.translation() = p_camera - result.linear() * p_mean;
  return result;
}

/// Features of the frame and where on the model they may be, the surest first.
struct Matches {
  std::vector<cv::Point3f> places;
  std::vector<cv::Point2f> pixels;  ///< without lens distortion

  void keep(const std::vector<bool>& kept) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!kept[i]) continue;
      places[count] = places[i];
      pixels[count++] = pixels[i];
    }
    places.resize(count);
    pixels.resize(count);
  }
};

}  // namespace

struct Detector::Impl {
  Impl(const ModelFeatures& model, const Camera& seen_by)
      : features(model),
        camera(seen_by),
        descriptors(comparable(model.data().descriptors)),
        trees(descriptors, cv::flann::KDTreeIndexParams(kTrees)) {
    camera.validate();
    K = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  }

  void undistort(std::vector<cv::Point2f>& pixels) const {
    if (!camera.has_distortion() || pixels.empty()) return;
    const int count = camera.lens == LensModel::fisheye ? 4 : 8;
    const cv::Mat distortion(1, count, CV_64F, const_cast<double*>(camera.distortion.data()));
    std::vector<cv::Point2f> straight;
    if (camera.lens == LensModel::fisheye) {
      cv::fisheye::undistortPoints(pixels, straight, K, distortion, cv::noArray(), K);
    } else {
      cv::undistortPoints(pixels, straight, K, distortion, cv::noArray(), K);
    }
    pixels = std::move(straight);
  }

  Matches match(const cv::Mat& grey, double scale) {
    const PictureFeatures found = features_of(grey, kMostFeatures);
    Matches matches;
    if (found.places.empty()) return matches;
    const cv::Mat query = comparable(found.descriptors);
    cv::Mat indices(query.rows, kNeighbours, CV_32S), squares(query.rows, kNeighbours, CV_32F);
    trees.knnSearch(query, indices, squares, kNeighbours, cv::flann::SearchParams(kChecks));
    struct Match {
      float ratio;
      int feature, place;
    };
    std::vector<Match> kept;
    const auto& places = features.data().p_object;
    const double apart = kElsewhere * features.data().radius;
    for (int i = 0; i < query.rows; ++i) {
      const int* nearest = indices.ptr<int>(i);
      const float* square = squares.ptr<float>(i);
      const Eigen::Vector3f& place = places[static_cast<std::size_t>(nearest[0])];
      int other = 1;
      while (other < kNeighbours - 1 &&
             (places[static_cast<std::size_t>(nearest[other])] - place).cast<double>().norm() < apart) {
        ++other;
      }
      const float ratio = std::sqrt(square[0] / std::max(square[other], 1e-12f));
      if (ratio < kRatio) kept.push_back({ratio, i, nearest[0]});
    }
    std::sort(kept.begin(), kept.end(), [](const Match& a, const Match& b) {
      return a.ratio != b.ratio ? a.ratio < b.ratio : a.feature < b.feature;
    });
    for (const Match& match : kept) {
      const Eigen::Vector3f& p = places[static_cast<std::size_t>(match.place)];
      matches.places.emplace_back(p.x(), p.y(), p.z());
      const cv::Point2f pixel = found.places[static_cast<std::size_t>(match.feature)].pt;
      const auto to_frame = [&](float value) { return static_cast<float>((value + 0.5) * scale - 0.5); };
      matches.pixels.emplace_back(to_frame(pixel.x), to_frame(pixel.y));
    }
    undistort(matches.pixels);
    return matches;
  }

  struct PoseFit {
    Pose T_camera_object;
    double pixels = 0;  ///< root mean square off
  };

  PoseFit refined(const std::vector<cv::Point3f>& places, const std::vector<cv::Point2f>& pixels,
                  const Pose& T_start) const {
    cv::Mat R(3, 3, CV_64F), rotation, translation(3, 1, CV_64F);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) R.at<double>(row, column) = T_start.linear()(row, column);
      translation.at<double>(row) = T_start.translation()(row);
    }
    cv::Rodrigues(R, rotation);
    cv::solvePnPRefineLM(places, pixels, K, cv::noArray(), rotation, translation);
    std::vector<cv::Point2f> projected;
    cv::projectPoints(places, rotation, translation, K, cv::noArray(), projected);
    const double off = cv::norm(projected, pixels, cv::NORM_L2);
    return {pose_of(rotation, translation), off / std::sqrt(static_cast<double>(places.size()))};
  }

  /// The poses that most matches agree on, the better one first; these matches are taken out.
  std::vector<PoseCandidate> consensus(Matches& matches, double scale) const {
    if (matches.places.size() < kLeastInliers) return {};
    cv::UsacParams parameters;
    parameters.confidence = 0.999;
    parameters.maxIterations = 3000;
    parameters.threshold = kInlierPixels * scale;
    parameters.sampler = cv::SAMPLING_PROSAC;
    parameters.score = cv::SCORE_METHOD_MSAC;
    parameters.loMethod = cv::LOCAL_OPTIM_INNER_LO;
    cv::Mat rotation, translation, inliers;
    cv::Mat camera_matrix = K.clone();
    const bool found = cv::solvePnPRansac(matches.places, matches.pixels, camera_matrix, cv::noArray(), rotation,
                                          translation, inliers, parameters);
    if (!found || inliers.total() < kLeastInliers) return {};
    std::vector<cv::Point3f> places;
    std::vector<cv::Point2f> pixels;
    std::vector<bool> rest(matches.places.size(), true);
    for (int i = 0; i < static_cast<int>(inliers.total()); ++i) {
      const auto index = static_cast<std::size_t>(inliers.at<int>(i));
      places.push_back(matches.places[index]);
      pixels.push_back(matches.pixels[index]);
      rest[index] = false;
    }
    matches.keep(rest);
    const PoseFit fit = refined(places, pixels, pose_of(rotation, translation));
    const int count = static_cast<int>(places.size());
    std::vector<PoseCandidate> candidates{{fit.T_camera_object, static_cast<int>(rest.size()), count}};
    const PoseFit other = refined(places, pixels, mirrored(places, fit.T_camera_object));
    const double apart = rotation_angle(fit.T_camera_object.linear() * other.T_camera_object.linear().transpose());
    if (apart > kOtherTurn && other.pixels < kAsGood * std::max(1.0, fit.pixels)) {
      candidates.push_back({other.T_camera_object, static_cast<int>(rest.size()), count});
      if (other.pixels < fit.pixels) std::swap(candidates[0], candidates[1]);
    }
    return candidates;
  }

  ModelFeatures features;
  Camera camera;
  cv::Mat K;
  cv::Mat descriptors;
  cv::flann::Index trees;
};

Detector::Detector(const ModelFeatures& features, const Camera& camera)
    : impl_(std::make_unique<Impl>(features, camera)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<PoseCandidate> Detector::detect(const ImageView& frame) const {
  const Camera& camera = impl_->camera;
  if (frame.data == nullptr || frame.width != camera.width || frame.height != camera.height) {
    throw Error(ErrorCode::image, "a frame of " + std::to_string(frame.width) + "x" + std::to_string(frame.height) +
                                      " pixels where the camera has " + std::to_string(camera.width) + "x" +
                                      std::to_string(camera.height));
  }
  cv::Mat grey = grey_of(frame);
  const double scale = std::max(1.0, std::sqrt(static_cast<double>(grey.total()) / kMostPixels));
  if (scale > 1) {
    cv::Mat smaller;
    cv::resize(grey, smaller, {}, 1 / scale, 1 / scale, cv::INTER_AREA);
    grey = smaller;
  }
  Matches matches = impl_->match(grey, scale);
  std::vector<PoseCandidate> candidates;
  while (candidates.size() < kMostCandidates) {
    const std::vector<PoseCandidate> agreed = impl_->consensus(matches, scale);
    if (agreed.empty()) break;
    candidates.insert(candidates.end(), agreed.begin(), agreed.end());
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const PoseCandidate& a, const PoseCandidate& b) { return a.inliers > b.inliers; });
  return candidates;
}

}  // namespace holdfast::detection
