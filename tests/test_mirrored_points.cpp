// Pairs with exchanged or mirrored coordinates: they fit their picture to some pixels.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <random>
#include <utility>
#include <vector>

#include "init/mirrored_points.hpp"
#include "init/pose_from_points.hpp"

using namespace holdfast;
using namespace holdfast::app;

TEST_CASE("Pairs of a mirror image are told, and no others") {
  const Camera camera{640, 480, 650, 650, 319.5, 239.5, {}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  std::normal_distribution<double> mark(0, 0.2);
  for (int trial = 0; trial < 20; ++trial) {
    CAPTURE(trial);
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(trial, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    pose.translation() << 0.02, -0.01, 0.5;
    std::vector<PointPair> pairs;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d point(place(random), place(random), place(random));
      pairs.push_back({point, camera.project(pose * point) + Eigen::Vector2d(mark(random), mark(random)), ""});
    }
    const auto said = [&](const std::vector<PointPair>& given) {
      return mirrored_points(given, camera, pose_from_points(given, camera).rms).value_or("");
    };
    CHECK(said(pairs).empty());
    std::vector<PointPair> rough = pairs;
    for (PointPair& pair : rough) pair.pixel += 8 * Eigen::Vector2d(mark(random), mark(random));
    CHECK(said(rough).empty());
    rough.resize(4);
    CHECK(said(rough).empty());
    std::vector<PointPair> mirrored = pairs;
    for (PointPair& pair : mirrored) pair.p_object.y() *= -1;
    CHECK(said(mirrored).find("mirrored model") != std::string::npos);
    for (PointPair& pair : pairs) std::swap(pair.pixel.x(), pair.pixel.y());
    CHECK(said(pairs).find("u and v exchanged") != std::string::npos);
  }
}
