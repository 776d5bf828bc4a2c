#include "init/refine_on_frame.hpp"

#include <fmt/format.h>

#include <cmath>

#include "holdfast/tracker.hpp"
#include "init/point_residuals.hpp"
#include "video/tracker_view.hpp"

namespace holdfast::app {
namespace {

constexpr int kMostRounds = 8;
constexpr double kSettled = 0.05;  // pixels
/// Pairs are marked to a few pixels: a refined pose may fit them somewhat worse than the pose made to fit them.
constexpr double kRmsFactor = 2;
constexpr double kRmsAllowance = 3;  // pixels

double distance(const std::vector<PointPair>& pairs, const Camera& camera, const Pose& a, const Pose& b) {
  std::vector<Eigen::Vector2d> apart = point_residuals(pairs, camera, a);
  const std::vector<Eigen::Vector2d> of_b = point_residuals(pairs, camera, b);
  for (std::size_t i = 0; i < apart.size(); ++i) {
    apart[i] -= of_b[i];
  }
  return root_mean_square(apart);
}

}  // namespace

RefinementOnFrame refine_on_frame(const Mesh& mesh, const Camera& camera, const Device& device, const cv::Mat& frame,
                                  const std::vector<PointPair>& pairs, const Pose& T_camera_object) {
  Tracker tracker(mesh, camera, {}, device);
  cv::Mat grey;
  const ImageView view = tracker_view(frame, grey);
  RefinementOnFrame refinement;
  refinement.T_camera_object = T_camera_object;
  FrameResult result;
  Pose pose = T_camera_object;
  for (int round = 0; round < kMostRounds; ++round) {
    result = tracker.refine(view, pose);
    const double moved = distance(pairs, camera, pose, result.T_camera_object);
    pose = result.T_camera_object;
    if (result.status == Status::lost || !(moved > kSettled)) {
      break;
    }
  }
  refinement.correlation = result.texture.correlation;
  refinement.moved = distance(pairs, camera, T_camera_object, pose);
  const double rms_before = root_mean_square(point_residuals(pairs, camera, T_camera_object));
  const double rms_after = root_mean_square(point_residuals(pairs, camera, pose));
  if (result.status == Status::lost) {
    refinement.reason = result.message;
  } else if (!(rms_after < kRmsFactor * rms_before + kRmsAllowance)) {
    refinement.reason = fmt::format("it went {:.1f} px away from the points", rms_after);
  } else {
    refinement.accepted = true;
    refinement.T_camera_object = pose;
  }
  return refinement;
}

}  // namespace holdfast::app
