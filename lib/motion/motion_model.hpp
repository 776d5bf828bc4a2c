#pragma once

#include <array>
#include <cstddef>

#include "base/corner_motion.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Predicts the next pose: the object's centre goes on at its last displacement, its orientation at its last rotation,
/// both changing as they last changed where that has led closer (equations 21 and 21a of docs/math.md).
class MotionModel {
 public:
  struct Hypotheses {
    std::array<Pose, 5> poses;
    int count = 0;
    int turned = 0;  ///< of these, the last ones
  };

  /// Without `accelerating` velocity is always taken to be constant.
  MotionModel(const Extent& extent, bool accelerating) : extent_(extent), accelerating_(accelerating) {}

  /// At rest.
  void reset(const Pose& T_camera_object);
  /// The next frame's pose was found; if it is not `exact`, the velocity's change is not known. `T_moved_to`: where its
  /// velocity has taken the object, which a pose that is not sure says little of.
  void advance(const Pose& T_camera_object, bool exact, const Pose& T_moved_to);
  void advance(const Pose& T_camera_object, bool exact) { advance(T_camera_object, exact, T_camera_object); }
  /// It was not: the pose stays where the object was last seen.
  void lose();
  /// While it is lost, the next frame tries this place too.
  void suspect(const Pose& T_camera_object);

  /// Where the object most likely is in the next frame, to go by the last ones alone: where it is suspected, else as
  /// predicted() if `velocity`, else where it was.
  Pose supposed(bool velocity) const;

  const Pose& pose() const { return T_; }

  bool lost() const { return lost_frames_ > 0; }
  /// It is lost, and predicted() still goes on as it moved.
  bool goes_on_unseen() const;

  /// Whether it is known how the object moves: it was followed over two frames in a row.
  bool moving() const { return moving_; }

  /// Where the object would be in the next frame, had it gone on as it last moved (for a while, when it is lost).
  Pose predicted() const;

  /// The same at constant velocity, whatever its acceleration.
  Pose steadily_predicted() const;

  /// The poses to try: the predicted one first when `velocity`, then no motion when `all` or when there is no velocity.
  /// While the object is lost and `all`: where it was, where it would be had it gone on, and each of them turned,
  /// another way every frame.
  Hypotheses hypotheses(bool velocity, bool all) const;

 private:
  /// Of the centre and of the orientation, a frame, camera frame.
  struct Velocity {
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  };

  static constexpr std::size_t kRemembered = 12;

  Extent extent_;
  bool accelerating_;
  Pose T_ = Pose::Identity();
  Velocity last_;                             ///< from the frame before
  Velocity expected_;                         ///< to the next
  Velocity accelerated_;                      ///< to the next, if the velocity goes on changing
  bool moving_ = false;                       ///< last_ is known
  bool changing_ = false;                     ///< accelerated_ is known
  std::array<double, kRemembered> strays_{};  ///< from constant velocity, of the last frames
  std::size_t stray_count_ = 0;               ///< of all frames in a row
  Pose T_suspected_ = Pose::Identity();
  bool suspected_ = false;
  int lost_frames_ = 0;

  Pose gone_on(const Velocity& velocity, int frames) const;
  /// Whether the velocity changes steadily enough to go on changing: it has just led astray by `stray`, which strays_
  /// holds already, with its last change going on by `accelerated_stray`.
  bool changes_steadily(double stray, double accelerated_stray) const;
  /// How far apart the object's corners appear at two poses, in apparent radii.
  double apart(const Pose& T_a, const Pose& T_b) const;
  Pose turned(const Pose& T_camera_object, int way) const;
};

}  // namespace holdfast
