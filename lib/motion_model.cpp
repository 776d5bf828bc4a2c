#include "motion_model.hpp"

#include <algorithm>

namespace holdfast {

namespace {

/// Turns that a lost object is looked for in, radians: about what the coarsest level converges from.
constexpr double kSearchTurn = 0.35;
/// A lost object goes on as it moved for this many frames, then is taken to have stopped.
constexpr int kGoesOnFor = 12;

}  // namespace

void MotionModel::reset(const Pose& T_camera_object) {
  T_ = T_camera_object;
  displacement_.setZero();
  rotation_.setIdentity();
  moving_ = false;
  lost_frames_ = 0;
  suspected_ = false;
}

void MotionModel::advance(const Pose& T_camera_object) {
  if (lost()) {
    // How it moved while it was lost says nothing of how it moves now.
    reset(T_camera_object);
    return;
  }
  displacement_ = T_camera_object * p_object_center_ - T_ * p_object_center_;
  rotation_ = T_camera_object.linear() * T_.linear().transpose();
  T_ = T_camera_object;
  moving_ = true;
}

void MotionModel::lose() {
  ++lost_frames_;
  suspected_ = false;
}

void MotionModel::suspect(const Pose& T_camera_object) {
  T_suspected_ = T_camera_object;
  suspected_ = true;
}

Pose MotionModel::extrapolated(int frames) const {
  const Eigen::AngleAxisd turn(rotation_);
  Pose predicted = Pose::Identity();
  predicted.linear() = Eigen::AngleAxisd(frames * turn.angle(), turn.axis()).toRotationMatrix() * T_.linear();
  predicted.translation() = T_ * p_object_center_ + frames * displacement_ - predicted.linear() * p_object_center_;
  return renormalized(predicted);
}

Pose MotionModel::predicted() const { return moving_ ? extrapolated(std::min(lost_frames_ + 1, kGoesOnFor)) : T_; }

Pose MotionModel::turned(const Pose& T_camera_object, int way) const {
  const double angle = (way % 2 == 0 ? 1 : -1) * kSearchTurn * (1 + (way / 6) % 2);
  Pose result = Pose::Identity();
  result.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit((way / 2) % 3)) * T_camera_object.linear();
  result.translation() = T_camera_object * p_object_center_ - result.linear() * p_object_center_;
  return result;
}

MotionModel::Hypotheses MotionModel::hypotheses(bool velocity, bool all) const {
  Hypotheses result;
  const auto add = [&](const Pose& pose) { result.poses[static_cast<std::size_t>(result.count++)] = pose; };
  if (lost()) {
    if (suspected_) add(T_suspected_);
    add(T_);
    if (!all) return result;
    const Pose gone_on = predicted();
    if (velocity && moving_) add(gone_on);
    add(turned(T_, lost_frames_));
    if (velocity && moving_) add(turned(gone_on, lost_frames_));
    return result;
  }
  if (velocity && moving_) add(extrapolated(1));
  if (all || result.count == 0) add(T_);
  return result;
}

}  // namespace holdfast
