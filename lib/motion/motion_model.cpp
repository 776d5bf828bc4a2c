#include "motion/motion_model.hpp"

#include <algorithm>

namespace holdfast {

namespace {

/// Turns that a lost object is looked for in, radians: about what the coarsest level converges from.
constexpr double kSearchTurn = 0.35;
/// A lost object goes on as it moved for this many frames, then is taken to have stopped.
constexpr int kGoesOnFor = 12;
/// Share of a change of velocity that the next one is expected to be.
constexpr double kGoesOnChanging = 0.75;
/// How many times the usual change of velocity is a sudden one, which does not go on.
constexpr double kSudden = 2;
/// Change of velocity, radii a frame, that is too large for the next one to be like it.
constexpr double kLargeChange = 0.05;

}  // namespace

void MotionModel::reset(const Pose& T_camera_object) {
  T_ = T_camera_object;
  last_ = expected_ = {};
  moving_ = changing_ = false;
  stray_count_ = 0;
  lost_frames_ = 0;
  suspected_ = false;
}

void MotionModel::advance(const Pose& T_camera_object, bool exact, const Pose& T_moved_to) {
  if (lost()) {
    // How it moved while it was lost says nothing of how it moves now.
    reset(T_camera_object);
    return;
  }
  const Velocity now{T_moved_to * extent_.p_object_center - T_ * extent_.p_object_center,
                     T_moved_to.linear() * T_.linear().transpose()};
  expected_ = now;
  if (moving_) {
    const double stray = apart(T_camera_object, steadily_predicted());
    strays_[stray_count_++ % kRemembered] = stray;
    const double accelerated_stray = changing_ ? apart(T_camera_object, gone_on(accelerated_, 1)) : stray;
    const Eigen::AngleAxisd turn(now.rotation), last_turn(last_.rotation);
    const Eigen::Vector3d w = turn.angle() * turn.axis();
    const Eigen::Vector3d w_next = w + kGoesOnChanging * (w - last_turn.angle() * last_turn.axis());
    accelerated_.displacement = now.displacement + kGoesOnChanging * (now.displacement - last_.displacement);
    accelerated_.rotation = Eigen::AngleAxisd(w_next.norm(), w_next.stableNormalized()).toRotationMatrix();
    changing_ = exact;
    if (changes_steadily(stray, accelerated_stray) && accelerating_ && exact) expected_ = accelerated_;
  }
  last_ = now;
  T_ = T_camera_object;
  moving_ = true;
}

bool MotionModel::changes_steadily(double stray, double accelerated_stray) const {
  std::array<double, kRemembered> sorted = strays_;
  const std::size_t count = std::min(stray_count_, kRemembered);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  return accelerated_stray < stray && stray < std::min(kLargeChange, kSudden * *middle);
}

bool MotionModel::goes_on_unseen() const { return lost() && moving_ && lost_frames_ < kGoesOnFor; }

void MotionModel::lose() {
  ++lost_frames_;
  suspected_ = false;
}

void MotionModel::suspect(const Pose& T_camera_object) {
  T_suspected_ = T_camera_object;
  suspected_ = true;
}

Pose MotionModel::gone_on(const Velocity& velocity, int frames) const {
  const Eigen::AngleAxisd turn(velocity.rotation);
  Pose predicted = Pose::Identity();
  predicted.linear() = Eigen::AngleAxisd(frames * turn.angle(), turn.axis()).toRotationMatrix() * T_.linear();
  predicted.translation() =
      T_ * extent_.p_object_center + frames * velocity.displacement - predicted.linear() * extent_.p_object_center;
  return renormalized(predicted);
}

double MotionModel::apart(const Pose& T_a, const Pose& T_b) const {
  const Camera camera{1, 1, 1, 1, 0, 0, {}};
  return corner_motion(extent_, camera, T_a, T_b) * (T_a * extent_.p_object_center).z() / extent_.radius;
}

Pose MotionModel::predicted() const {
  return moving_ ? gone_on(expected_, std::min(lost_frames_ + 1, kGoesOnFor)) : T_;
}

Pose MotionModel::steadily_predicted() const { return moving_ ? gone_on(last_, 1) : T_; }

Pose MotionModel::supposed(bool velocity) const {
  if (suspected_) return T_suspected_;
  return velocity ? predicted() : T_;
}

Pose MotionModel::turned(const Pose& T_camera_object, int way) const {
  const double angle = (way % 2 == 0 ? 1 : -1) * kSearchTurn * (1 + (way / 6) % 2);
  Pose result = Pose::Identity();
  result.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit((way / 2) % 3)) * T_camera_object.linear();
  result.translation() = T_camera_object * extent_.p_object_center - result.linear() * extent_.p_object_center;
  return result;
}

MotionModel::Hypotheses MotionModel::hypotheses(bool velocity, bool all) const {
  Hypotheses result;
  const auto add = [&](const Pose& pose) { result.poses[static_cast<std::size_t>(result.count++)] = pose; };
  if (lost()) {
    if (suspected_) add(T_suspected_);
    add(T_);
    if (!all) return result;
    const Pose T_gone_on = predicted();
    if (velocity && moving_) add(T_gone_on);
    add(turned(T_, lost_frames_));
    if (velocity && moving_) add(turned(T_gone_on, lost_frames_));
    result.turned = velocity && moving_ ? 2 : 1;
    return result;
  }
  if (velocity && moving_) add(gone_on(expected_, 1));
  if (all || result.count == 0) add(T_);
  return result;
}

}  // namespace holdfast
