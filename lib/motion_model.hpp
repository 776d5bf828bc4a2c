#pragma once

#include <array>

#include "holdfast/pose.hpp"

namespace holdfast {

/// Predicts the next pose: the object's centre goes on at its last displacement, its orientation at its last rotation.
class MotionModel {
 public:
  struct Hypotheses {
    std::array<Pose, 5> poses;
    int count = 0;
  };

  explicit MotionModel(const Eigen::Vector3d& p_object_center) : p_object_center_(p_object_center) {}

  /// At rest.
  void reset(const Pose& T_camera_object);
  /// The next frame's pose was found.
  void advance(const Pose& T_camera_object);
  /// It was not: the pose stays where the object was last seen.
  void lose();
  /// While it is lost, the next frame tries this place too.
  void suspect(const Pose& T_camera_object);

  const Pose& pose() const { return T_; }

  bool lost() const { return lost_frames_ > 0; }

  /// Whether it is known how the object moves: it was followed over two frames in a row.
  bool moving() const { return moving_; }

  /// Where the object would be in the next frame, had it gone on as it last moved (for a while, when it is lost).
  Pose predicted() const;

  /// The poses to try: constant velocity first when `velocity`, then no motion when `all` or when there is no velocity.
  /// While the object is lost and `all`: where it was, where it would be had it gone on, and each of them turned,
  /// another way every frame.
  Hypotheses hypotheses(bool velocity, bool all) const;

 private:
  Eigen::Vector3d p_object_center_;
  Pose T_ = Pose::Identity();
  Eigen::Vector3d displacement_ = Eigen::Vector3d::Zero();  ///< of the centre, a frame, camera frame
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();  ///< a frame, camera frame
  bool moving_ = false;
  Pose T_suspected_ = Pose::Identity();
  bool suspected_ = false;
  int lost_frames_ = 0;

  Pose extrapolated(int frames) const;
  Pose turned(const Pose& T_camera_object, int way) const;
};

}  // namespace holdfast
