#include "keyframes.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Appearances nearer than this to each other, radians, are one: the coarse stage converges over that distance.
constexpr double kSpread = 0.3;
/// A lost object is looked for turned by these, radians.
constexpr std::array<double, 2> kTurns = {0.35, 0.7};
/// How near or far it may have gone meanwhile, from one pass over the plan to the next.
constexpr std::array<double, 3> kDistances = {1.0, 0.8, 1.25};

double angle_between(const Pose& a, const Pose& b) { return rotation_angle(a.linear().transpose() * b.linear()); }

}  // namespace

Eigen::Matrix3d Keyframes::to_axis(const Eigen::Vector3d& p_camera) {
  return Eigen::Quaterniond::FromTwoVectors(p_camera, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Pose Keyframes::appearance(const Pose& T_camera_object) const {
  Pose result = Pose::Identity();
  const Eigen::Matrix3d turn = to_axis(T_camera_object * p_object_center_);
  result.linear() = turn * T_camera_object.linear();
  result.translation() = turn * T_camera_object.translation();
  return renormalized(result);
}

void Keyframes::remember(const Pose& T_camera_object) {
  const Pose pose = appearance(T_camera_object);
  for (int i = 0; i < count_; ++i) {
    if (angle_between(poses_[static_cast<std::size_t>(i)], pose) < kSpread) {
      poses_[static_cast<std::size_t>(i)] = pose;  // the later one knows the distance better
      return;
    }
  }
  if (count_ < kMost) {
    poses_[static_cast<std::size_t>(count_++)] = pose;
    return;
  }
  int most_crowded = 0;
  double least = 10;
  for (int i = 0; i < kMost; ++i) {
    for (int j = 0; j < i; ++j) {
      const double angle = angle_between(poses_[static_cast<std::size_t>(i)], poses_[static_cast<std::size_t>(j)]);
      if (angle < least) {
        least = angle;
        most_crowded = j;
      }
    }
  }
  poses_[static_cast<std::size_t>(most_crowded)] = pose;
}

void Keyframes::plan(const Pose& T_camera_object_last) {
  const Pose last = appearance(T_camera_object_last);
  const Eigen::Vector3d p_center = last * p_object_center_;
  planned_count_ = next_ = 0;
  const auto add = [&](const Eigen::Matrix3d& R_camera_object) {
    if (planned_count_ == kMostPlanned) return;
    Pose pose = Pose::Identity();
    pose.linear() = R_camera_object;
    pose.translation() = p_center - R_camera_object * p_object_center_;
    for (int i = 0; i < planned_count_; ++i) {
      if (angle_between(planned_[static_cast<std::size_t>(i)], pose) < 0.7 * kSpread) return;
    }
    planned_[static_cast<std::size_t>(planned_count_++)] = pose;
  };
  add(last.linear());
  for (const double turn : kTurns) {
    // Remembered appearances are likelier than any others as far away.
    std::array<int, kMost> order{};
    for (int i = 0; i < count_; ++i) order[static_cast<std::size_t>(i)] = i;
    const auto distance = [&](int i) { return angle_between(poses_[static_cast<std::size_t>(i)], last); };
    std::sort(order.begin(), order.begin() + count_, [&](int a, int b) { return distance(a) < distance(b); });
    for (int i = 0; i < count_; ++i) {
      const int keyframe = order[static_cast<std::size_t>(i)];
      if (distance(keyframe) <= turn) add(poses_[static_cast<std::size_t>(keyframe)].linear());
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double angle : {turn, -turn}) {
        add(Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)) * last.linear());
      }
    }
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d axis((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
      add(Eigen::AngleAxisd(turn, axis.normalized()) * last.linear());
    }
  }
  for (int i = 0; i < count_; ++i) add(poses_[static_cast<std::size_t>(i)].linear());
}

Pose Keyframes::next() {
  const auto place = static_cast<std::size_t>(next_ % planned_count_);
  const auto pass = static_cast<std::size_t>(next_ / planned_count_) % kDistances.size();
  ++next_;
  Pose pose = planned_[place];
  const Eigen::Vector3d p_center = pose * p_object_center_;
  pose.translation() += (kDistances[pass] - 1) * p_center;
  return pose;
}

}  // namespace holdfast
