// What a drawn view says of the surface in it.
#include <doctest/doctest.h>

#include <cmath>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "image/view_template.hpp"
#include "support/painted_object.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

/// Degrees between the plane found nearest to the quad, drawn at this pose on this level, and the quad.
double tilt_error(const Pose& T_camera_object, int level) {
  const Device device;
  const auto levels = make_levels(kRenderCamera, 2);
  ImageFilter filter(device.impl());
  const Mesh mesh = quad(random_texture(32, 32, 1));
  ViewTemplate view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter);
  ViewRequest request;
  request.T_camera_object = T_camera_object;
  request.finest = level;
  REQUIRE(view.enqueue(request));
  const auto normal = view.flat_normal(0.001);
  REQUIRE(normal.has_value());
  const Eigen::Vector3d axis = T_camera_object.linear().col(2);
  const Eigen::Vector3d towards_camera = axis.dot(T_camera_object.translation()) < 0 ? axis : -axis;
  return std::atan2(normal->cross(towards_camera).norm(), normal->dot(towards_camera)) * 180 / 3.14159265358979;
}

}  // namespace

TEST_CASE("the plane nearest to a flat object drawn is its own, wherever it is and however tilted") {
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0, 0, 0.4), Eigen::Vector3d(0.5, -0.3, 0.2),
                                      Eigen::Vector3d(-1.0, 0.4, 0), Eigen::Vector3d(0.2, 1.1, -0.5)}) {
    CAPTURE(turn.transpose());
    CHECK(tilt_error(pose_at({0.02, -0.01, 0.5}, turn), 0) < 0.05);
    CHECK(tilt_error(pose_at({-0.1, 0.05, 0.9}, turn), 0) < 0.05);
    CHECK(tilt_error(pose_at({0.02, -0.01, 0.5}, turn), 1) < 0.05);
  }
}

TEST_CASE("an object that is a few pixels large has no plane") {
  const Device device;
  const auto levels = make_levels(kRenderCamera, 2);
  ImageFilter filter(device.impl());
  const Mesh mesh = quad(random_texture(32, 32, 1));
  ViewTemplate view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter);
  ViewRequest request;
  request.T_camera_object = pose_at({0, 0, 15});
  REQUIRE(view.enqueue(request));
  CHECK_FALSE(view.flat_normal(0.001).has_value());
}

TEST_CASE("what is seen of a box has a plane only as far as so much depth about it is allowed") {
  const Device device;
  const auto levels = make_levels(kRenderCamera, 2);
  ImageFilter filter(device.impl());
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {0.1F, 0.1F, 0.1F});
  ViewTemplate view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter);
  ViewRequest request;
  request.T_camera_object = pose_at({0, 0, 0.6}, {0, 0.785, 0});
  REQUIRE(view.enqueue(request));
  // Two faces that slant away by 71 mm each: deviation from their middle plane 71 / sqrt(12) mm.
  CHECK_FALSE(view.flat_normal(0.018).has_value());
  REQUIRE(view.flat_normal(0.023).has_value());
  CHECK(view.flat_normal(0.023)->z() < -0.99);
}
