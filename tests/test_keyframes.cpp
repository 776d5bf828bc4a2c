// The appearances that a lost object is searched in: which are remembered, and in which order they are tried.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "keyframes.hpp"

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
  CHECK(keyframes.count() == 1);
  pose.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  keyframes.remember(pose);
  CHECK(keyframes.count() == 2);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Quaterniond turned(normal(random), normal(random), normal(random), normal(random));
    pose.linear() = turned.normalized().toRotationMatrix();
    keyframes.remember(pose);
  }
  CHECK(keyframes.count() == 24);
  keyframes.clear();
  CHECK(keyframes.count() == 0);
}

TEST_CASE("a plan begins with the appearance last seen, centred, and covers all turns of 40 degrees within 25") {
  const Eigen::Vector3d p_object_center(0.01, 0.02, 0.03);
  Keyframes keyframes(p_object_center);
  Pose last = Pose::Identity();
  last.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  last.translation() = Eigen::Vector3d(0.2, -0.1, 0.8);
  keyframes.plan(last);
  std::vector<Pose> planned;
  for (int i = 0; i < 29; ++i) planned.push_back(keyframes.next());
  const Eigen::Vector3d p_center = planned[0] * p_object_center;
  CHECK(p_center.head<2>().norm() < 1e-9);
  CHECK(p_center.z() == doctest::Approx((last * p_object_center).norm()));
  // The same appearance: the view from the camera in the object's frame has not changed.
  const Eigen::Vector3d before = last.linear().transpose() * (last * p_object_center).normalized();
  const Eigen::Vector3d after = planned[0].linear().transpose() * p_center.normalized();
  CHECK((before - after).norm() < 1e-9);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  double farthest = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d axis(normal(random), normal(random), normal(random));
    const Eigen::Matrix3d there =
        Eigen::AngleAxisd(40 * kPi / 180, axis.normalized()).toRotationMatrix() * planned[0].linear();
    double nearest = 10;
    for (const Pose& pose : planned) nearest = std::min(nearest, rotation_angle(pose.linear().transpose() * there));
    farthest = std::max(farthest, nearest);
  }
  CHECK(farthest < 25 * kPi / 180);
}
