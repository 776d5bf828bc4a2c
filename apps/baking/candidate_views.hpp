#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::baking {

/// The views that brought colours which another view, from elsewhere, has yet to confirm.
class CandidateViews {
 public:
  /// `confirming_motion`: pixels that the object's corners move by until a view is from elsewhere.
  CandidateViews(const Mesh& mesh, const Camera& camera, double confirming_motion);

  /// No more fit in.
  bool full() const;
  void clear() { poses_.clear(); }
  /// The view's number.
  std::uint16_t add(const Pose& T_camera_object);
  /// True where the object has moved between this view and the one added last.
  bool moved_since(std::uint16_t view) const { return moved_[view]; }

 private:
  double corner_motion(const Pose& T_a, const Pose& T_b) const;

  Eigen::Vector3d p_center_;  // object frame
  double radius_;
  Camera camera_;
  double confirming_motion_;
  std::vector<Pose> poses_;
  std::vector<bool> moved_;
};

}  // namespace holdfast::baking
