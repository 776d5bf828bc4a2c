#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <opencv2/calib3d.hpp>

#include "base/turns.hpp"
#include "detection/frame_mat.hpp"
#include "detection/matcher.hpp"
#include "detection/robust_pnp.hpp"

namespace holdfast::detection {
namespace {

constexpr std::size_t kMostCandidates = 4;
/// A mirrored tilt is another pose from so many radians on, and one to look at if it is at most so many times as far
/// off.
constexpr double kOtherTurn = 0.1, kAsGood = 3;

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
  const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(normal, image).toRotationMatrix();
  return anchored(turn * T_camera_object.linear(), p_mean, p_camera);
}

}  // namespace

struct Detector::Impl {
  Impl(const ModelFeatures& model, const Camera& seen_by) : camera(seen_by), matcher(model) {
    camera.validate();
    K = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  }

  /// The poses that most matches agree on, the better one first; these matches are taken out.
  std::vector<PoseCandidate> agreed(Matches& matches) const {
    const int count = static_cast<int>(matches.places.size());
    const std::optional<Consensus> most = take_consensus(matches, K);
    if (!most) return {};
    const auto refined = [&](const Pose& T) { return refined_pose(most->places, most->pixels, K, T); };
    const auto candidate = [&](const PoseFit& fit) {
      return PoseCandidate{fit.T_camera_object, count, static_cast<int>(most->places.size()), 0};
    };
    const PoseFit fit = refined(most->T_camera_object);
    std::vector<PoseCandidate> candidates{candidate(fit)};
    const PoseFit other = refined(mirrored(most->places, fit.T_camera_object));
    const double apart = rotation_angle(fit.T_camera_object.linear() * other.T_camera_object.linear().transpose());
    if (apart > kOtherTurn && other.pixels < kAsGood * std::max(1.0, fit.pixels)) {
      candidates.push_back(candidate(other));
      if (other.pixels < fit.pixels) std::swap(candidates[0], candidates[1]);
    }
    return candidates;
  }

  Camera camera;
  Matcher matcher;
  cv::Mat K;
};

Detector::Detector(const ModelFeatures& features, const Camera& camera)
    : impl_(std::make_unique<Impl>(features, camera)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<PoseCandidate> Detector::detect(const ImageView& frame) const {
  require_size(frame, impl_->camera);
  Matches matches = impl_->matcher.match(frame);
  undistort(impl_->camera, matches.pixels);
  std::vector<PoseCandidate> candidates;
  while (candidates.size() < kMostCandidates) {
    const std::vector<PoseCandidate> agreed = impl_->agreed(matches);
    if (agreed.empty()) break;
    candidates.insert(candidates.end(), agreed.begin(), agreed.end());
  }
  std::ranges::stable_sort(candidates, std::greater{}, &PoseCandidate::inliers);
  return candidates;
}

}  // namespace holdfast::detection
