#pragma once

#include <optional>

#include "holdfast/tracker.hpp"

namespace holdfast::baking {

/// Follows an object by its shape alone beside a tracker whose texture comes from the frames themselves: such a texture
/// is wherever the tracker was when it was taken, so that it agrees however far both have drifted. The outline does not
/// drift.
class OutlineGuard {
 public:
  /// Throws as Tracker does.
  OutlineGuard(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device);

  /// The first pose as the outline shows it in the first frame; none where that is not clear, and the given one is
  /// kept.
  std::optional<Pose> first_pose(const ImageView& frame, const Pose& T_camera_object);

  const Eigen::Vector3d& p_object_center() const { return p_object_center_; }

  /// `result`: the tracker's of this frame. Where the outline shows the object clearly and elsewhere, or the tracker
  /// has lost it, the tracker is reset to that pose, and the shape's result is returned; otherwise `result`.
  FrameResult check(Tracker& tracker, const ImageView& frame, std::optional<double> time_s, const FrameResult& result);

 private:
  bool apart(const Pose& T_a, const Pose& T_b) const;

  Tracker shape_;
  Eigen::Vector3d p_object_center_;
  double radius_;
};

}  // namespace holdfast::baking
