// Light as the renderer draws it, beside what a formula says of the surface that each pixel's ray meets.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

constexpr std::uint8_t kPaint = 200;

Mesh painted(Mesh mesh) {
  mesh.colors.assign(mesh.positions.size(), {kPaint, kPaint, kPaint, 255});
  return mesh;
}

/// 12 triangles that share 8 vertices: nothing but their angles says that there are edges.
Mesh plain_box(const Eigen::Vector3d& half) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(Eigen::Vector3d((i & 1) != 0 ? half.x() : -half.x(),
                                                (i & 2) != 0 ? half.y() : -half.y(),
                                                (i & 4) != 0 ? half.z() : -half.z())
                                    .cast<float>());
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return painted(std::move(mesh));
}

/// Of a ray from `origin` along `direction` (object frame), the unit normal where it meets the object; empty: it does
/// not, or too near an edge to tell.
using Surface = std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

/// The largest difference, of 255, between what is drawn and equation 15a of docs/math.md; few pixels: a failure.
double worst_difference(const Mesh& mesh, const Pose& pose, const Eigen::Vector3d& light, const Surface& surface) {
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  renderer.set_shading(light);
  const View view = draw(renderer, pose);
  const Pose T_object_camera = pose.inverse();
  double worst = 0;
  int compared = 0;
  for (int row = 0; row < view.roi.height; ++row) {
    for (int column = 0; column < view.roi.width; ++column) {
      const Eigen::Vector3d ray((column - kRenderCamera.cx) / kRenderCamera.fx,
                                (row - kRenderCamera.cy) / kRenderCamera.fy, 1);
      const std::optional<Eigen::Vector3d> normal =
          surface(T_object_camera.translation(), T_object_camera.linear() * ray);
      if (!normal || !view.drawn(column, row)) continue;
      Eigen::Vector3d n = pose.linear() * *normal;
      if (n.dot(ray) > 0) n = -n;
      const double bright = kPaint * (1 + light.dot(n)) / (1 + light.norm());
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(view.pixel(column, row)[c] - bright));
      ++compared;
    }
  }
  CHECK(compared > 1500);
  return worst;
}

const std::array<Eigen::Vector3d, 3> kLights{Eigen::Vector3d(-0.3, -0.2, -0.4), Eigen::Vector3d(0.5, 0.1, 0.2),
                                             Eigen::Vector3d(0, 0, -0.7)};

/// Of what lies in the plane of x and y.
std::optional<Eigen::Vector3d> facing_z(const Eigen::Vector3d&, const Eigen::Vector3d&) {
  return Eigen::Vector3d::UnitZ();
}

}  // namespace

TEST_CASE("every face of a box is evenly lit, whoever shares its vertices") {
  const Eigen::Vector3d half(0.08, 0.06, 0.05);
  const Mesh box = plain_box(half);
  const Surface surface = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    std::optional<Eigen::Vector3d> normal;
    for (int axis = 0; axis < 3; ++axis) {
      const double side = direction(axis) > 0 ? -1 : 1;
      const Eigen::Vector3d at = origin + (side * half(axis) - origin(axis)) / direction(axis) * direction;
      bool inside = true;
      for (int other = 0; other < 3; ++other) inside &= other == axis || std::abs(at(other)) < half(other) - 0.003;
      if (inside) normal = side * Eigen::Vector3d::Unit(axis);
    }
    return normal;
  };
  for (const Eigen::Vector3d& light : kLights) {
    for (const double turn : {0.3, 1.2, 3.7}) {
      CHECK(worst_difference(box, pose_at({0.03, -0.02, 0.4}, {0.5, turn, 0.2}), light, surface) < 0.51);
    }
  }
}

TEST_CASE("surface that is open is lit as it faces the camera, however its triangles are wound") {
  Mesh sheet;
  sheet.positions = {{-0.1F, -0.08F, 0}, {0.1F, -0.08F, 0}, {0.1F, 0.08F, 0}, {-0.1F, 0.08F, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 3, 2}};  // one's front is the other's back
  sheet = painted(std::move(sheet));
  for (const Eigen::Vector3d& light : kLights) {
    for (const double turn : {0.4, 3.5}) {
      CHECK(worst_difference(sheet, pose_at({0.05, -0.02, 0.45}, {0.2, turn, 0.1}), light, facing_z) < 0.51);
    }
  }
}
