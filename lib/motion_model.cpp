#include "motion_model.hpp"

namespace holdfast {

void MotionModel::reset(const Pose& T_camera_object) {
  T_ = T_camera_object;
  stop();
}

void MotionModel::advance(const Pose& T_camera_object) {
  displacement_ = T_camera_object * p_object_center_ - T_ * p_object_center_;
  rotation_ = T_camera_object.linear() * T_.linear().transpose();
  T_ = T_camera_object;
  moving_ = true;
}

void MotionModel::stop() {
  displacement_.setZero();
  rotation_.setIdentity();
  moving_ = false;
}

MotionModel::Hypotheses MotionModel::hypotheses(bool velocity, bool all) const {
  Hypotheses result;
  if (velocity && moving_) {
    Pose predicted = Pose::Identity();
    predicted.linear() = rotation_ * T_.linear();
    predicted.translation() = T_ * p_object_center_ + displacement_ - predicted.linear() * p_object_center_;
    result.poses[static_cast<std::size_t>(result.count++)] = renormalized(predicted);
  }
  if (all || result.count == 0) result.poses[static_cast<std::size_t>(result.count++)] = T_;
  return result;
}

}  // namespace holdfast
