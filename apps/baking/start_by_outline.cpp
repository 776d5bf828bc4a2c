#include "baking/start_by_outline.hpp"

#include <fmt/format.h>

#include "messages.hpp"
#include "video/tracker_view.hpp"

namespace holdfast::app {

Pose start_by_outline(baking::OutlineGuard& guard, const cv::Mat& frame, const Pose& T_camera_object, bool quiet) {
  cv::Mat grey;
  const std::optional<Pose> found = guard.first_pose(tracker_view(frame, grey), T_camera_object);
  if (!found) {
    print_warning(
        "the model's outline is not clear at the first pose, which is kept as given: check the pose, the model and its "
        "unit, and that the object is in full view");
    return T_camera_object;
  }
  const Pose& T_first = *found;
  constexpr double kDegrees = 57.29577951308232;
  const Eigen::Vector3d& p = guard.p_object_center();
  if (!quiet) {
    print_note(fmt::format("the outline moves the first pose by {:.1f} mm and {:.1f} degrees",
                           1e3 * (T_first * p - T_camera_object * p).norm(),
                           kDegrees * rotation_angle(T_first.linear() * T_camera_object.linear().transpose())));
  }
  return T_first;
}

}  // namespace holdfast::app
