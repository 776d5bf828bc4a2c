#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "detection/feature_data.hpp"
#include "detection/frame_mat.hpp"
#include "detection/matcher.hpp"
#include "holdfast/detection.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::detection {
namespace {

/// Frames that show the object from directions nearer than this to each other, radians, are looked at once.
constexpr double kSameSide = 0.26;
/// Matches that agree with the pose, this many of which are enough to be recognized by, and pixels that they may be
/// off.
constexpr int kEnough = 30;
constexpr double kAgreeing = 5;
/// Share of the contour's lines whose edge is there where nothing hides the object.
constexpr double kUnhidden = 0.75;
/// The same of texture's pixels with a gradient, where the contour was not asked.
constexpr double kUnhiddenTexture = 0.5;
/// Features of a side, at most and at least; pixels that they keep off the silhouette.
constexpr int kMostOfFrame = 1500;
constexpr std::size_t kMost = 300, kFewest = 20;
constexpr float kMargin = 3;
/// Sides of all runs together.
constexpr std::size_t kMostFeatures = 12000;

bool is_hidden(const FrameResult& result) {
  const ContourEvidence& contour = result.contour;
  if (contour.asked) return contour.near_lines < kUnhidden * contour.lines;
  return !result.texture.holds || result.texture.inlier_ratio() < kUnhiddenTexture;
}

}  // namespace

struct SightLearner::Impl {
  Impl(const Mesh& mesh, const Camera& seen_by, const ModelFeatures& known_features, const ModelFeatures& seen_before)
      : camera(seen_by),
        known(known_features),
        seen(seen_before),
        renderer(mesh, seen_by.width, seen_by.height),
        window(seen_by.height, seen_by.width, CV_32F) {
    camera.validate();
    remake_matcher();
  }

  void remake_matcher() {
    const ModelFeatures all = known.with(seen);
    matcher.reset();
    if (all.count() >= kFewest) matcher.emplace(all);
  }

  bool is_recognized(const ImageView& frame, const Pose& T_camera_object) {
    if (!matcher) return false;
    Matches matches = matcher->match(frame);
    undistort(camera, matches.pixels);
    int agreeing = 0;
    for (std::size_t i = 0; i < matches.places.size(); ++i) {
      const cv::Point3f& place = matches.places[i];
      const Eigen::Vector3d p = T_camera_object * Eigen::Vector3d(place.x, place.y, place.z);
      if (p.z() <= 0) continue;
      const Eigen::Vector2d off = camera.project(p) - Eigen::Vector2d(matches.pixels[i].x, matches.pixels[i].y);
      agreeing += off.norm() < kAgreeing * matches.pixel_scale;
    }
    return agreeing >= kEnough;
  }

  /// The features on the object, and their places.
  bool learn(const ImageView& frame, const Pose& T_camera_object) {
    const DepthRange range = renderer.render(T_camera_object, camera, {0, 0, camera.width, camera.height},
                                             {nullptr, window.ptr<float>(), camera.width});
    cv::Mat inside;
    cv::distanceTransform(window < 1, inside, cv::DIST_L2, 3);
    const PictureFeatures found = features_of(grey_of(frame), kMostOfFrame);
    std::vector<cv::Point2f> pixels;
    for (const cv::KeyPoint& place : found.places) pixels.push_back(place.pt);
    undistort(camera, pixels);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const cv::Point pixel(cvRound(pixels[i].x), cvRound(pixels[i].y));
      const bool in_picture = pixel.x >= 0 && pixel.y >= 0 && pixel.x < camera.width && pixel.y < camera.height;
      if (in_picture && inside.at<float>(pixel) >= std::max(kMargin, 0.5f * found.places[i].size)) order.push_back(i);
    }
    if (order.size() < kFewest) return false;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return found.places[a].response > found.places[b].response; });
    order.resize(std::min(order.size(), kMost));
    ModelFeatures::Data added{seen.data().hash, seen.data().radius, {}, {}};
    const Pose T_object_camera = T_camera_object.inverse();
    for (const std::size_t i : order) {
      const cv::Point2f& pixel = pixels[i];
      const double z = range.metric(static_cast<double>(window.at<float>(cvRound(pixel.y), cvRound(pixel.x))));
      added.add(found.descriptors.row(static_cast<int>(i)), pixel, z, camera, T_object_camera);
    }
    seen = seen.with(ModelFeatures(std::make_shared<const ModelFeatures::Data>(std::move(added))));
    remake_matcher();
    return true;
  }

  Camera camera;
  ModelFeatures known, seen;
  Renderer renderer;
  cv::Mat window;
  std::optional<Matcher> matcher;  ///< of all features; none while they are too few
  std::vector<Eigen::Matrix3d> looked_from;
};

SightLearner::SightLearner(const Mesh& mesh, const Camera& camera, const ModelFeatures& known,
                           const ModelFeatures& seen)
    : impl_(std::make_unique<Impl>(mesh, camera, known, seen)) {}
SightLearner::~SightLearner() = default;
SightLearner::SightLearner(SightLearner&&) noexcept = default;
SightLearner& SightLearner::operator=(SightLearner&&) noexcept = default;

bool SightLearner::look(const ImageView& frame, const FrameResult& result) {
  require_size(frame, impl_->camera);
  if (result.status != Status::held || impl_->seen.count() + kMost > kMostFeatures) return false;
  if (is_hidden(result)) return false;
  const Eigen::Matrix3d R = result.T_camera_object.linear();
  const auto near = [&](const Eigen::Matrix3d& other) { return rotation_angle(R * other.transpose()) < kSameSide; };
  if (std::any_of(impl_->looked_from.begin(), impl_->looked_from.end(), near)) return false;
  impl_->looked_from.push_back(R);
  if (impl_->is_recognized(frame, result.T_camera_object)) return false;
  return impl_->learn(frame, result.T_camera_object);
}

const ModelFeatures& SightLearner::seen() const { return impl_->seen; }

}  // namespace holdfast::detection
