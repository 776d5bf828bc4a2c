#include "recovery/keyframes.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Appearances nearer than this to each other, radians, are one: the coarse stage converges over that distance.
constexpr double kSpread = 0.3;
/// Turns that a lost object is looked for in: a body-centred cubic lattice of rotation vectors, the one that covers
/// with the fewest points. None within the largest turn is farther from all of them than sqrt(5) / 4 of the spacing.
constexpr double kSpacing = 0.42, kMostTurn = 0.95;
/// Remembered appearances farther than this from all of these are looked for too, after them.
constexpr double kElsewhere = 0.3;
/// How near or far it may have gone meanwhile.
constexpr std::array<double, 2> kDistances = {0.89, 1.13};

double angle_between(const Pose& a, const Pose& b) { return rotation_angle(a.linear().transpose() * b.linear()); }

}  // namespace

Keyframes::Keyframes(const Eigen::Vector3d& p_object_center) : p_object_center_(p_object_center) {
  const int reach = static_cast<int>(kMostTurn / kSpacing) + 1;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      for (int k = -reach; k <= reach; ++k) {
        for (const double offset : {0.0, 0.5}) {
          const Eigen::Vector3d turn = kSpacing * (Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(offset));
          if (turn.norm() <= kMostTurn && turns_.size() < kMostTurns) turns_.push_back(turn);
        }
      }
    }
  }
  const auto smaller = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.norm() < b.norm(); };
  std::stable_sort(turns_.begin(), turns_.end(), smaller);
}

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
    planned_[static_cast<std::size_t>(planned_count_++)] = pose;
  };
  for (const Eigen::Vector3d& turn : turns_) {
    const double angle = turn.norm();
    add(angle > 0 ? Eigen::AngleAxisd(angle, turn / angle) * last.linear() : last.linear());
  }
  for (int i = 0; i < count_; ++i) {
    const Pose& pose = poses_[static_cast<std::size_t>(i)];
    const auto near = [&](const Pose& planned) { return angle_between(planned, pose) < kElsewhere; };
    if (std::none_of(planned_.begin(), planned_.begin() + planned_count_, near)) add(pose.linear());
  }
}

int Keyframes::planned() const { return planned_count_ * static_cast<int>(kDistances.size()); }

Pose Keyframes::next() {
  const auto place = static_cast<std::size_t>(next_) / kDistances.size();
  const auto distance = static_cast<std::size_t>(next_) % kDistances.size();
  next_ = (next_ + 1) % planned();
  Pose pose = planned_[place];
  const Eigen::Vector3d p_center = pose * p_object_center_;
  pose.translation() += (kDistances[distance] - 1) * p_center;
  return pose;
}

}  // namespace holdfast
