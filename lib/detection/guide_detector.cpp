#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/turns.hpp"
#include "detection/contour_template.hpp"
#include "detection/frame_mat.hpp"
#include "holdfast/detection.hpp"
#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

/// Frames are looked at as if they had so many columns.
constexpr double kColumns = 320;
/// Turns (turn_lattice()), radians, and shares of the distance around the guide that are drawn.
constexpr double kMostTurn = 0.38, kTurnSpacing = 0.19;
constexpr double kLeastDistance = 0.8, kDistanceStep = 1.085;
constexpr int kDistances = 6;
constexpr std::size_t kMostPoints = 160, kLeastPoints = 24;
/// Pixels between the shifts that are tried, and that an edge may be off.
constexpr int kStep = 2, kReach = 2;
/// Response where there is no edge; 255 where all agrees.
constexpr int kNothing = 64;
/// Levels a pixel below which a gradient is noise.
constexpr float kNoise = 4;
constexpr int kCandidates = 6;
/// Candidates nearer than this to a better one are the same: pixels, radians.
constexpr double kSamePixels = 6, kSameTurn = 0.15;

struct ContourTemplate {
  Pose T_camera_object;
  std::vector<ContourPoint> points;
};

/// Adds the part of `plane` from `first` on to the sums.
void add(const cv::Mat& plane, cv::Point first, cv::Mat& sums) {
  for (int row = 0; row < sums.rows; ++row) {
    const std::uint8_t* from = plane.ptr<std::uint8_t>(first.y + row) + first.x;
    std::uint16_t* to = sums.ptr<std::uint16_t>(row);
    for (int column = 0; column < sums.cols; ++column) {
      to[column] = static_cast<std::uint16_t>(to[column] + from[column]);
    }
  }
}

}  // namespace

struct GuideDetector::Impl {
  Impl(const Mesh& mesh, const Camera& seen_by, const Pose& T_guide) : camera(seen_by), p_center(mesh.center()) {
    camera.validate();
    mesh.validate();
    validate_pose(T_guide);
    const double scale = kColumns / camera.width;
    small =
        camera.rescaled(static_cast<int>(kColumns), std::max(1, static_cast<int>(std::lround(camera.height * scale))));
    small.distortion = {};
    small.lens = LensModel::polynomial;
    const Eigen::Vector3d p = T_guide * p_center;
    if (p.z() <= 0) {
      throw Error(ErrorCode::pose, "the guide puts the object behind the camera (z = " + std::to_string(p.z()) +
                                       " m); poses map object to camera coordinates, z forward");
    }
    ContourDrawer drawer(mesh, small);
    for (const Eigen::Vector3d& turn : turn_lattice(kMostTurn, kTurnSpacing)) {
      const Eigen::Matrix3d R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      for (int i = 0; i < kDistances; ++i) {
        ContourTemplate drawn;
        drawn.T_camera_object =
            anchored(R * T_guide.linear(), p_center, kLeastDistance * std::pow(kDistanceStep, i) * p);
        drawn.points = drawer.draw(drawn.T_camera_object, kMostPoints);
        if (drawn.points.size() >= kLeastPoints) templates.push_back(std::move(drawn));
      }
    }
    if (templates.empty()) throw Error(ErrorCode::pose, "the guide puts the object out of the picture");
    if (!camera.has_distortion()) return;
    map_x.create(small.height, small.width, CV_32F);
    map_y.create(small.height, small.width, CV_32F);
    const double rows = static_cast<double>(small.height) / camera.height;
    for (int y = 0; y < small.height; ++y) {
      for (int x = 0; x < small.width; ++x) {
        const Eigen::Vector2d recorded = camera.distort({(x + 0.5) / scale - 0.5, (y + 0.5) / rows - 0.5});
        map_x.at<float>(y, x) = static_cast<float>((recorded.x() + 0.5) * scale - 0.5);
        map_y.at<float>(y, x) = static_cast<float>((recorded.y() + 0.5) * rows - 0.5);
      }
    }
  }

  /// The frame at the templates' size, without lens distortion.
  cv::Mat picture_of(const ImageView& frame) const {
    cv::Mat picture;
    cv::resize(channels_of(frame), picture, {small.width, small.height}, 0, 0, cv::INTER_AREA);
    if (map_x.empty()) return picture;
    cv::Mat straight;
    cv::remap(picture, straight, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return straight;
  }

  /// For each direction, how well an edge near each kStep-th pixel agrees with it, 0 to 255.
  std::vector<cv::Mat> responses(const cv::Mat& channels) const {
    const EdgePicture edges = edges_of(channels);
    std::vector<cv::Mat> of_direction;
    const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kReach + 1, 2 * kReach + 1});
    for (int d = 0; d < kDirections; ++d) {
      cv::Mat seen = (edges.direction == d) & (edges.strength > kNoise), spread;
      cv::dilate(seen, spread, kernel);
      of_direction.push_back(spread);
    }
    std::vector<cv::Mat> result;
    for (int d = 0; d < kDirections; ++d) {
      const auto at = [&](int by) -> const cv::Mat& {
        return of_direction[static_cast<std::size_t>((d + by + kDirections) % kDirections)];
      };
      cv::Mat near, response, across;
      cv::max(at(-1), at(1), near);
      cv::max(at(0), near * 0.6, response);
      cv::max(at(3), at(5), across);
      cv::max(at(4), across, across);
      // In clutter there are edges of all directions: those across speak against the place.
      cv::Mat value;
      cv::addWeighted(response, 0.75, across, -0.25, kNothing, value);
      result.push_back(value);
    }
    return result;
  }

  /// Responses of every kStep-th pixel, from each of the first kStep * kStep on: shifts are then neighbours in memory.
  /// Beyond the picture, as far as templates are shifted, nothing agrees.
  std::vector<cv::Mat> planes_of(const std::vector<cv::Mat>& of_direction, cv::Size reach) const {
    std::vector<cv::Mat> planes;
    for (const cv::Mat& response : of_direction) {
      cv::Mat wide;
      cv::copyMakeBorder(response, wide, reach.height * kStep, (reach.height + 1) * kStep, reach.width * kStep,
                         (reach.width + 1) * kStep, cv::BORDER_CONSTANT, kNothing);
      for (int from = 0; from < kStep * kStep; ++from) {
        const int oy = from / kStep, ox = from % kStep;
        cv::Mat plane((wide.rows - oy) / kStep, (wide.cols - ox) / kStep, CV_8U);
        for (int y = 0; y < plane.rows; ++y) {
          for (int x = 0; x < plane.cols; ++x) {
            plane.at<std::uint8_t>(y, x) = wide.at<std::uint8_t>(y * kStep + oy, x * kStep + ox);
          }
        }
        planes.push_back(plane);
      }
    }
    return planes;
  }

  /// A template at the place where it agrees best.
  struct Peak {
    double score;
    const ContourTemplate* shown;
    cv::Point shift;
  };

  /// Every template's, the best first.
  std::vector<Peak> peaks(const std::vector<cv::Mat>& of_direction) const {
    const cv::Size reach(small.width / 4 / kStep, small.height / 4 / kStep);
    const std::vector<cv::Mat> planes = planes_of(of_direction, reach);
    cv::Mat sums(2 * reach.height + 1, 2 * reach.width + 1, CV_16U);
    std::vector<Peak> all;
    for (const ContourTemplate& shown : templates) {
      sums.setTo(0);
      for (const ContourPoint& point : shown.points) {
        const int plane = (point.direction * kStep + point.y % kStep) * kStep + point.x % kStep;
        add(planes[static_cast<std::size_t>(plane)], {point.x / kStep, point.y / kStep}, sums);
      }
      double best = 0;
      cv::Point place;
      cv::minMaxLoc(sums, nullptr, &best, nullptr, &place);
      const double score = (best / static_cast<double>(shown.points.size()) - kNothing) / (255 - kNothing);
      all.push_back({score, &shown, {(place.x - reach.width) * kStep, (place.y - reach.height) * kStep}});
    }
    std::ranges::stable_sort(all, std::greater{}, &Peak::score);
    return all;
  }

  /// The poses of the best peaks, without those that repeat a better one.
  std::vector<PoseCandidate> candidates(const std::vector<Peak>& best_first) const {
    std::vector<PoseCandidate> kept;
    for (const Peak& peak : best_first) {
      if (kept.size() == kCandidates) break;
      // The same appearance along another ray: its middle is shifted, and it is turned with the ray.
      const Pose& T = peak.shown->T_camera_object;
      const Eigen::Vector3d p = T * p_center;
      const Eigen::Vector3d shifted = p + Eigen::Vector3d(peak.shift.x / small.fx, peak.shift.y / small.fy, 0) * p.z();
      PoseCandidate candidate;
      candidate.score = peak.score;
      candidate.T_camera_object =
          anchored(Eigen::Quaterniond::FromTwoVectors(p, shifted) * T.linear(), p_center, shifted);
      const auto same = [&](const PoseCandidate& other) {
        const Eigen::Vector2d apart = small.project(shifted) - small.project(other.T_camera_object * p_center);
        const Eigen::Matrix3d turn = other.T_camera_object.linear() * candidate.T_camera_object.linear().transpose();
        return apart.norm() < kSamePixels && rotation_angle(turn) < kSameTurn;
      };
      if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(candidate);
    }
    return kept;
  }

  Camera camera, small;
  Eigen::Vector3d p_center;
  cv::Mat map_x, map_y;  ///< empty without lens distortion
  std::vector<ContourTemplate> templates;
};

GuideDetector::GuideDetector(const Mesh& mesh, const Camera& camera, const Pose& T_guide)
    : impl_(std::make_unique<Impl>(mesh, camera, T_guide)) {}
GuideDetector::~GuideDetector() = default;
GuideDetector::GuideDetector(GuideDetector&&) noexcept = default;
GuideDetector& GuideDetector::operator=(GuideDetector&&) noexcept = default;

std::vector<PoseCandidate> GuideDetector::detect(const ImageView& frame) const {
  require_size(frame, impl_->camera);
  return impl_->candidates(impl_->peaks(impl_->responses(impl_->picture_of(frame))));
}

}  // namespace holdfast::detection
