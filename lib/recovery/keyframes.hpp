#pragma once

#include <vector>

#include "holdfast/pose.hpp"

namespace holdfast {

/// How the object looked while it was held: a few poses, well spread over directions of view, that it is searched in
/// when it is lost. Only the pose is kept, not pixels: the textured model shows what it looks like from there, at any
/// resolution and under the light as it was last.
///
/// Poses are kept as *appearances*: turned about the camera so that the object's centre lies on the optical axis.
/// Turned back to any other ray they look the same there.
class Keyframes {
 public:
  /// Radians that a lost object may have turned by since it was seen, and from which on a remembered appearance is
  /// looked for beside these turns.
  static constexpr double kMostTurn = 0.95, kElsewhere = 0.3;

  explicit Keyframes(const Eigen::Vector3d& p_object_center);

  /// Forgets everything.
  void clear() { poses_.clear(); }

  /// The object was surely held at this pose. Remembered if it is far from all others; the one that is nearest to
  /// another makes room.
  void remember(const Pose& T_camera_object);

  /// What is remembered, as appearances.
  const std::vector<Pose>& remembered() const { return poses_; }

  /// Begins a search for an object last seen at this pose: appearances in the order they are to be tried in, that one
  /// first, then turned away from it, farther and farther, then those remembered that are none of these.
  void plan(const Pose& T_camera_object_last);

  /// The next appearance of the plan, each somewhat nearer and somewhat farther away; after the last comes the first
  /// again.
  Pose next();

  /// After how many the first comes again.
  int planned() const;

  /// The rotation about the camera that brings a point of this direction onto the optical axis.
  static Eigen::Matrix3d to_axis(const Eigen::Vector3d& p_camera);

 private:
  static constexpr std::size_t kMost = 24;

  Pose appearance(const Pose& T_camera_object) const;

  Eigen::Vector3d p_object_center_;
  std::vector<Eigen::Vector3d> turns_;  ///< rotation vectors, the smallest first
  std::vector<Pose> poses_, planned_;
  int next_ = 0;
};

}  // namespace holdfast
