// The appearances that a lost object is searched in: which are remembered, and in which order they are tried.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "recovery/keyframes.hpp"

namespace {

using namespace holdfast;

constexpr double kPi = 3.14159265358979323846;

}  // namespace

TEST_CASE("keyframes are spread: near ones replace each other, and the most crowded makes room") {
  Keyframes keyframes(Eigen::Vector3d(0.01, 0.02, 0.03));
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(0.1, -0.05, 0.7);
  keyframes.remember(pose);
  pose.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()));
  keyframes.remember(pose);
  CHECK(keyframes.remembered().size() == 1);
  pose.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  keyframes.remember(pose);
  CHECK(keyframes.remembered().size() == 2);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Quaterniond turned(normal(random), normal(random), normal(random), normal(random));
    pose.linear() = turned.normalized().toRotationMatrix();
    keyframes.remember(pose);
  }
  CHECK(keyframes.remembered().size() == 24);
  keyframes.clear();
  CHECK(keyframes.remembered().size() == 0);
}

TEST_CASE("a plan begins with the appearance last seen, centred, and covers all turns of 40 degrees within 14") {
  const Eigen::Vector3d p_object_center(0.01, 0.02, 0.03);
  Keyframes keyframes(p_object_center);
  Pose last = Pose::Identity();
  last.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  last.translation() = Eigen::Vector3d(0.2, -0.1, 0.8);
  keyframes.plan(last);
  const double distance = (last * p_object_center).norm();
  std::vector<Pose> planned;
  double nearest_by = 10, farthest_by = 0;
  for (int i = 0; i < keyframes.planned(); ++i) {
    planned.push_back(keyframes.next());
    const Eigen::Vector3d p_center = planned.back() * p_object_center;
    CHECK(p_center.head<2>().norm() < 1e-9);
    nearest_by = std::min(nearest_by, p_center.z() / distance);
    farthest_by = std::max(farthest_by, p_center.z() / distance);
  }
  // The distance changes by as much on either side; a quarter is reached from there within an eighth.
  CHECK(nearest_by * 1.25 > 1);
  CHECK(nearest_by < 0.9);
  CHECK(farthest_by > 1.1);
  CHECK(farthest_by < 1.25);
  // The same appearance: the view from the camera in the object's frame has not changed.
  const Eigen::Vector3d before = last.linear().transpose() * (last * p_object_center).normalized();
  const Eigen::Vector3d after = planned[0].linear().transpose() * (planned[0] * p_object_center).normalized();
  CHECK((before - after).norm() < 1e-9);
  const Pose again = keyframes.next();
  CHECK((again.matrix() - planned[0].matrix()).norm() < 1e-12);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> turn(0, 40 * kPi / 180);
  double farthest = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d axis(normal(random), normal(random), normal(random));
    const Eigen::Matrix3d there =
        Eigen::AngleAxisd(turn(random), axis.normalized()).toRotationMatrix() * planned[0].linear();
    double nearest = 10;
    for (const Pose& pose : planned) nearest = std::min(nearest, rotation_angle(pose.linear().transpose() * there));
    farthest = std::max(farthest, nearest);
  }
  CHECK(farthest < 14 * kPi / 180);
}

TEST_CASE("what was remembered is looked for too, however far it is turned") {
  Keyframes keyframes(Eigen::Vector3d::Zero());
  Pose seen = Pose::Identity();
  seen.translation().z() = 0.6;
  seen.linear() = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix();
  keyframes.remember(seen);
  Pose last = Pose::Identity();
  last.translation().z() = 0.9;
  keyframes.remember(last);
  keyframes.plan(last);
  double nearest = 10;
  for (int i = 0; i < keyframes.planned(); ++i) {
    const Pose planned = keyframes.next();
    nearest = std::min(nearest, rotation_angle(planned.linear().transpose() * seen.linear()));
    CHECK(std::abs(planned.translation().z() / 0.9 - 1) < 0.25);  // where it is now, not where it was then
  }
  CHECK(nearest < 1e-9);
}
