#include "init/guided_pose.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "holdfast/detection.hpp"
#include "init/check_picture.hpp"
#include "slow_notice.hpp"
#include "track/outline.hpp"
#include "video/tracker_view.hpp"

namespace holdfast::app {
namespace {

/// Widths of the picture that the diagonal of an object at a guide is not beyond.
constexpr double kMostWidths = 2.5;

}  // namespace

std::optional<std::string> guide_doubt(const Pose& T_guide, const Mesh& mesh, const Camera& camera) {
  const double z = (T_guide * mesh.center()).z();
  if (z <= 0) return std::nullopt;  // said where it is looked for
  const double widths = std::max(camera.fx, camera.fy) * 2 * mesh.radius() / z / std::max(camera.width, camera.height);
  if (widths < kMostWidths) return std::nullopt;
  return fmt::format(
      "at the guide the object's diagonal is {:.2g} times the picture's width, too large for its outline to be seen: "
      "check the model's unit (--model-scale) and the guide's (metres)",
      widths);
}

std::optional<Pose> pose_near(const Pose& T_guide, const Mesh& mesh, const Camera& camera,
                              const DeviceArguments& device, const cv::Mat& frame) {
  const detection::GuideDetector detector(mesh, camera, T_guide);
  const SlowNotice notice(preparing_stream(device.options.cache_folder), kPreparing);
  Tracker tracker(mesh, camera, {}, device.open());
  cv::Mat grey;
  const ImageView view = tracker_view(frame, grey);
  const auto found = detection::start_near(tracker, detector.detect(view), view);
  return found ? std::optional(found->T_camera_object) : std::nullopt;
}

cv::Mat guide_picture(const Pose& T_guide, const std::optional<Pose>& T_camera_object, const Mesh& mesh,
                      const Camera& camera, const cv::Mat& frame) {
  EnlargedFrame enlarged(frame);
  Outline outline(mesh, camera);
  enlarged.draw_lines(outline.lines(T_guide), camera, {0, 140, 255});
  if (T_camera_object) enlarged.draw_lines(outline.lines(*T_camera_object), camera, {120, 255, 90});
  return enlarged.picture();
}

}  // namespace holdfast::app
