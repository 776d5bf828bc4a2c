#include "recovery/keyframes.hpp"

#include <algorithm>
#include <array>

#include "base/turns.hpp"

namespace holdfast {
namespace {

/// Appearances nearer than this to each other, radians, are one: the coarse stage converges over that distance.
constexpr double kSpread = 0.3;
/// Radians between the turns (turn_lattice()) that a lost object is looked for in.
constexpr double kSpacing = 0.42;
/// How near or far it may have gone meanwhile.
constexpr std::array<double, 2> kDistances = {0.89, 1.13};

}  // namespace

Keyframes::Keyframes(const Eigen::Vector3d& p_object_center)
    : p_object_center_(p_object_center), turns_(turn_lattice(kMostTurn, kSpacing)) {
  std::ranges::stable_sort(turns_, {}, [](const Eigen::Vector3d& turn) { return turn.norm(); });
  poses_.reserve(kMost);
  planned_.reserve(turns_.size() + kMost);
}

Eigen::Matrix3d Keyframes::to_axis(const Eigen::Vector3d& p_camera) {
  return Eigen::Quaterniond::FromTwoVectors(p_camera, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Pose Keyframes::appearance(const Pose& T_camera_object) const {
  return renormalized(Pose(to_axis(T_camera_object * p_object_center_)) * T_camera_object);
}

void Keyframes::remember(const Pose& T_camera_object) {
  const Pose pose = appearance(T_camera_object);
  for (Pose& remembered : poses_) {
    if (turn_between(remembered, pose) < kSpread) {
      remembered = pose;  // the later one knows the distance better
      return;
    }
  }
  if (poses_.size() < kMost) {
    poses_.push_back(pose);
    return;
  }
  std::size_t most_crowded = 0;
  double least = 10;
  for (std::size_t i = 0; i < kMost; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double angle = turn_between(poses_[i], poses_[j]);
      if (angle < least) {
        least = angle;
        most_crowded = j;
      }
    }
  }
  poses_[most_crowded] = pose;
}

void Keyframes::plan(const Pose& T_camera_object_last) {
  const Pose last = appearance(T_camera_object_last);
  const Eigen::Vector3d p_center = last * p_object_center_;
  planned_.clear();
  next_ = 0;
  const auto add = [&](const Eigen::Matrix3d& R_camera_object) {
    planned_.push_back(anchored(R_camera_object, p_object_center_, p_center));
  };
  for (const Eigen::Vector3d& turn : turns_) {
    add(Eigen::AngleAxisd(turn.norm(), turn.normalized()) * last.linear());
  }
  for (const Pose& pose : poses_) {
    const auto near = [&](const Pose& planned) { return turn_between(planned, pose) < kElsewhere; };
    if (std::ranges::none_of(planned_, near)) add(pose.linear());
  }
}

int Keyframes::planned() const { return static_cast<int>(planned_.size()) * static_cast<int>(kDistances.size()); }

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
