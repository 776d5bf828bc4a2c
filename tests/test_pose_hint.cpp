// Poses in another program's convention: each of them is recognised, and what it is said to be turns it into the right
// one. Points' distance from a mesh.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <optional>
#include <string>

#include "holdfast/error.hpp"
#include "init/surface_distance.hpp"
#include "support/check_error.hpp"
#include "track/pose_hint.hpp"

using namespace holdfast;
using namespace holdfast::app;

namespace {

Pose some_pose() {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  pose.translation() << 0.05, -0.03, 0.6;
  return pose;
}

Mesh box() {
  Mesh mesh;
  mesh.positions = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                    {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  for (Eigen::Vector3f& position : mesh.positions) position *= 0.05F;
  return mesh;
}

}  // namespace

TEST_CASE("Every convention's pose is told as that") {
  const Pose truth = some_pose();
  const Eigen::Matrix3d flip = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const auto said = [&](const Pose& given) {
    return pose_hint(given, true, [&](const Pose& pose) { return pose.isApprox(truth, 1e-9); }).value_or("");
  };
  Pose given = truth;
  given.linear() = flip * truth.linear();
  CHECK(said(given).find("rotation still in OpenGL's axes") != std::string::npos);
  given.translation() = flip * truth.translation();
  CHECK(said(given).find("in OpenGL's axes, y up and z backwards") != std::string::npos);
  given.linear() = truth.linear();
  CHECK(said(given).find("translation still in OpenGL's axes") != std::string::npos);
  CHECK(said(truth.inverse()).find("as camera to object (invert it)") != std::string::npos);
  given = truth;
  given.linear().transposeInPlace();
  CHECK(said(given).find("rotation transposed") != std::string::npos);
  given.linear() = truth.linear() * Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  given.translation() = truth.translation();
  CHECK(said(given).find("y up where this one has z") != std::string::npos);
  given.linear() = truth.linear() * Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  CHECK(said(given).find("z up where this one has y") != std::string::npos);
  const Eigen::Quaterniond q(truth.linear());
  given.linear() = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();  // w x y z read as x y z w
  CHECK(said(given).find("w, x, y, z") != std::string::npos);
  given.linear() = Eigen::AngleAxisd(truth.translation().norm(), truth.translation().normalized()).toRotationMatrix();
  given.translation() = 0.7 * Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  CHECK(said(given).find("tvec before rvec") != std::string::npos);
  CHECK_FALSE(pose_hint(truth, true, [](const Pose&) { return false; }));
}

TEST_CASE("A start that no reading explains says how much of the contour is there") {
  FrameResult first;
  CHECK(lost_start(first).find("contour") == std::string::npos);
  first.contour.lines = 200;
  first.contour.near_lines = 14;
  CHECK(lost_start(first).find("at 7 % of the model's contour") != std::string::npos);
  first.contour.near_lines = 150;
  CHECK(lost_start(first).find("model's contour") == std::string::npos);
}

TEST_CASE("An object behind the camera or out of the picture is refused with what may be meant") {
  const Camera camera{640, 480, 600, 600, 319.5, 239.5, {}};
  CHECK_NOTHROW(require_in_view(box(), camera, some_pose()));
  Pose pose = some_pose();
  pose.translation().z() = -0.6;
  CHECK_ERROR(require_in_view(box(), camera, pose), ErrorCode::pose, "behind the camera", "OpenGL", "invert it");
  pose.translation() << 0.05, -0.9, 0.6;
  CHECK_ERROR(require_in_view(box(), camera, pose), ErrorCode::pose, "out of the picture", "unit");
  // tvec 0.05 -0.03 0.6 before rvec 1.5 0.4 0.3
  pose.linear() = Eigen::AngleAxisd(0.603, Eigen::Vector3d(0.05, -0.03, 0.6).normalized()).toRotationMatrix();
  pose.translation() << 1.5, 0.4, 0.3;
  CHECK_ERROR(require_in_view(box(), camera, pose), ErrorCode::pose, "out of the picture", "tvec before rvec");
}

TEST_CASE("The distance of a point to a box") {
  const Mesh mesh = box();
  CHECK(distance_to_surface(mesh, {0.05, 0.01, 0.02}) == doctest::Approx(0).epsilon(1e-9));
  CHECK(distance_to_surface(mesh, {0, 0, 0}) == doctest::Approx(0.05));
  CHECK(distance_to_surface(mesh, {0, 0.08, 0.01}) == doctest::Approx(0.03));
  CHECK(distance_to_surface(mesh, {0.08, 0.09, 0}) == doctest::Approx(0.05));
  CHECK(distance_to_surface(mesh, {0.06, 0.07, 0.07}) == doctest::Approx(0.03));
}
