// What the renderer draws: mask, depth and colours of every pixel against a ray caster.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "base/closed_surface.hpp"
#include "support/ray_caster.hpp"
#include "support/render_comparison.hpp"

namespace holdfast {
namespace {

using namespace test;

/// The same box with all fronts outwards.
Mesh outward_box() {
  Mesh mesh = colored_box();
  for (auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.positions[triangle[i]]; };
    const Eigen::Vector3f normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (normal.dot(corner(0)) < 0) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

}  // namespace

TEST_CASE("A box with several materials agrees with the ray caster from all sides") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 12; ++i) {
    const Pose pose = pose_at({0.03 * normal(random), 0.02 * normal(random), 0.5 + 0.03 * normal(random)},
                              {2 * normal(random), 2 * normal(random), 2 * normal(random)});
    CAPTURE(i);
    const Comparison comparison = compare(mesh, pose, kRenderCamera, draw(renderer, pose));
    check_geometry(comparison);
    CHECK(comparison.surface_pixels > 500);
    CHECK(comparison.known == comparison.surface_pixels);
    CHECK(10 * comparison.colors > 8 * comparison.surface_pixels);
    CHECK(comparison.color_error <= 2);
  }
}

TEST_CASE("Closed meshes are told from others, and without their backs look the same") {
  const Mesh closed = outward_box();
  CHECK(is_closed_outward(closed));
  CHECK_FALSE(is_closed_outward(colored_box()));  // some of its faces look inwards
  Mesh open = closed;
  open.triangles.pop_back();
  open.triangle_materials.pop_back();
  CHECK_FALSE(is_closed_outward(open));
  Mesh inverted = closed;
  for (auto& triangle : inverted.triangles) std::swap(triangle[1], triangle[2]);
  CHECK_FALSE(is_closed_outward(inverted));
  Mesh hollow = closed;  // a cavity within: closed, but part of it looks inwards
  for (std::size_t i = 0; i < closed.positions.size(); ++i) {
    hollow.positions.push_back(0.5F * closed.positions[i]);
    hollow.texture_coordinates.push_back(closed.texture_coordinates[i]);
    hollow.colors.push_back(closed.colors[i]);
  }
  const auto offset = static_cast<std::uint32_t>(closed.positions.size());
  for (std::size_t i = 0; i < closed.triangles.size(); ++i) {
    const auto& t = closed.triangles[i];
    hollow.triangles.push_back({t[0] + offset, t[2] + offset, t[1] + offset});
    hollow.triangle_materials.push_back(closed.triangle_materials[i]);
  }
  CHECK_FALSE(is_closed_outward(hollow));

  Renderer renderer(closed, kRenderCamera.width, kRenderCamera.height),
      inside_too(open, kRenderCamera.width, kRenderCamera.height);
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    const Eigen::Vector3d rotation(2 * normal(random), 2 * normal(random), 2 * normal(random));
    const Pose pose = pose_at({0.0, 0.01, 0.5}, rotation);
    const Comparison comparison = compare(closed, pose, kRenderCamera, draw(renderer, pose));
    check_geometry(comparison);
    CHECK(comparison.surface_pixels > 500);
    // Cut open by the near plane, the inside shows; depths that close to the camera are coarse.
    const Pose around = pose_at({0.0, 0.01, 0.03}, rotation);
    const Comparison cut = compare(closed, around, kRenderCamera, draw(renderer, around, kRenderCamera));
    CHECK(cut.mask_errors == 0);
    CHECK(cut.alpha_errors == 0);
    CHECK(cut.depth_error < 1e-3);
    check_geometry(compare(open, pose, kRenderCamera, draw(inside_too, pose, kRenderCamera)));
  }
}

TEST_CASE("A finely textured quad, magnified, has the bilinear colours") {
  const Mesh mesh = quad(random_texture(64, 48, 9));
  const Camera camera{321, 243, 611.7, 587.2, 171.3, 109.6, {}};
  for (const int samples : {1, 4}) {
    CAPTURE(samples);
    Renderer renderer(mesh, camera.width, camera.height, {samples});
    for (const Eigen::Vector3d& rotation : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.3, -0.4, 0.2)}) {
      const Pose pose = pose_at({-0.01, 0.02, 0.45}, rotation);
      const View view = draw(renderer, pose, camera);
      const Comparison comparison = compare(mesh, pose, camera, view, false, samples);
      check_geometry(comparison);
      CHECK(comparison.colors > 30000);
      CHECK(comparison.color_error <= 2);
    }
  }
}

TEST_CASE("A slanted surface shows what falls on its pixels, not blurred across its slant") {
  // 72 degrees about the image's horizontal: about one texel a pixel across, three down.
  const Mesh mesh = quad(random_texture(200, 200, 4));
  const Camera camera{240, 120, 600, 600, 119.5, 59.5, {}};
  const Pose pose = pose_at({0, 0, 0.6}, {1.26, 0, 0});
  Renderer renderer(mesh, camera.width, camera.height);
  const View view = draw(renderer, pose, camera);
  const RayCaster caster(mesh, pose);
  double drawn = 0, seen = 0, drawn2 = 0, seen2 = 0, both = 0;
  long count = 0;
  for (int y = 40; y < 80; ++y) {
    for (int x = 40; x < 200; ++x) {
      double light = 0;  // of 64 rays through the pixel
      for (int i = 0; i < 64; ++i) {
        const auto hit = caster.cast(camera, {x + (i % 8 - 3.5) / 8, y + (i / 8 - 3.5) / 8});
        if (!hit) FAIL("the quad does not fill the window");
        light += std::pow(caster.color(*hit)[0], 2) / 64;
      }
      const double a = view.pixel(x, y)[0], b = std::sqrt(light);
      ++count;
      drawn += a;
      seen += b;
      drawn2 += a * a;
      seen2 += b * b;
      both += a * b;
    }
  }
  const double n = static_cast<double>(count);
  const double variance_drawn = drawn2 / n - drawn * drawn / (n * n), variance_seen = seen2 / n - seen * seen / (n * n);
  const double correlation = (both / n - drawn * seen / (n * n)) / std::sqrt(variance_drawn * variance_seen);
  CHECK(correlation > 0.9);
  CHECK(std::abs(std::sqrt(variance_drawn / variance_seen) - 1) < 0.15);
}

TEST_CASE("Rows run from the top down and the texture's first row is v = 1") {
  Texture texture = plain_texture(2, {0, 0, 0, 255});
  texture.rgba[0] = 255;   // upper left red
  texture.rgba[5] = 255;   // upper right green
  texture.rgba[10] = 255;  // lower left blue
  const Mesh mesh = quad(texture);
  const Camera camera{64, 64, 200, 200, 31.5, 31.5, {}};
  Renderer renderer(mesh, 64, 64);
  const View view = draw(renderer, pose_at({0, 0, 1}), camera);
  CHECK(view.pixel(14, 14)[0] == 255);
  CHECK(view.pixel(49, 14)[1] == 255);
  CHECK(view.pixel(14, 49)[2] == 255);
  CHECK(view.pixel(49, 49)[0] + view.pixel(49, 49)[1] + view.pixel(49, 49)[2] == 0);
}

TEST_CASE("An object behind the camera is not drawn, one partly behind it is cut at the near plane") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  const View behind = draw(renderer, pose_at({0, 0, -0.5}), kRenderCamera);
  CHECK(behind.drawn_count() == 0);
  CHECK(std::all_of(behind.rgba.begin(), behind.rgba.end(), [](std::uint8_t value) { return value == 0; }));
  CHECK(std::all_of(behind.window_depth.begin(), behind.window_depth.end(), [](float depth) { return depth == 1; }));
  CHECK(behind.range.near_plane > 0);
  CHECK(behind.range.far_plane > behind.range.near_plane);

  // The camera inside the box, and the box's long axis running past the camera.
  for (const Pose& pose :
       {pose_at({0.01, 0.02, 0.01}, {0.2, 0.1, 0.3}), pose_at({0.08, 0.05, 0.03}, {0.1, 1.4, 0.2})}) {
    const View view = draw(renderer, pose, kRenderCamera);
    CHECK(view.range.near_plane > 0);
    CHECK(view.range.near_plane < 0.01 * view.range.far_plane);
    const Comparison comparison = compare(mesh, pose, kRenderCamera, view);
    CHECK(comparison.surface_pixels > 500);
    CHECK(comparison.mask_errors == 0);
    CHECK(comparison.alpha_errors == 0);
    // A near plane at 1/1000 of the far plane costs digits: 1000 times the rounding of a float in [0.5, 1].
    CHECK(comparison.depth_error < 1e-4);
  }
}

TEST_CASE("Vertex colours are interpolated in perspective; without colours a surface is drawn but unknown") {
  Mesh mesh = colored_box();
  mesh.materials.clear();
  mesh.triangle_materials.clear();
  const Pose pose = pose_at({0.01, -0.02, 0.45}, {0.5, 0.6, 0.2});
  {
    Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
    const Comparison comparison = compare(mesh, pose, kRenderCamera, draw(renderer, pose));
    check_geometry(comparison);
    CHECK(comparison.colors == comparison.surface_pixels);
    CHECK(comparison.colors > 500);
    CHECK(comparison.color_error <= 1);
  }
  mesh.colors.clear();
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  const View view = draw(renderer, pose, kRenderCamera);
  const Comparison comparison = compare(mesh, pose, kRenderCamera, view);
  check_geometry(comparison);
  CHECK(comparison.surface_pixels > 500);
  CHECK(view.known_count() == 0);
}

TEST_CASE("Unknown surface hides what lies behind it") {
  Mesh mesh = quad(plain_texture(4, {200, 100, 50, 255}));
  // A smaller square without texture in front of the textured one.
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3f corner = 0.5F * mesh.positions[i];
    mesh.positions.push_back(corner - Eigen::Vector3f(0, 0, 0.05F));
    mesh.texture_coordinates.push_back({0, 0});
  }
  mesh.triangles.push_back({4, 5, 6});
  mesh.triangles.push_back({4, 6, 7});
  mesh.materials.push_back({"none", {}});
  mesh.triangle_materials = {0, 0, 1, 1};
  Renderer renderer(mesh, 101, 101);
  const Camera camera{101, 101, 200, 200, 50, 50, {}};
  const View view = draw(renderer, pose_at({0, 0, 0.5}), camera);
  CHECK(view.pixel(50, 50)[3] == 0);
  CHECK(view.depth(50, 50) == doctest::Approx(0.45).epsilon(1e-5));
  CHECK(view.pixel(20, 50)[3] == 255);
  CHECK(view.pixel(20, 50)[0] == 200);
  CHECK(view.depth(20, 50) == doctest::Approx(0.5).epsilon(1e-5));
}

TEST_CASE("Texels never seen are drawn, but unknown, and do not tint their neighbours") {
  SUBCASE("magnified") {
    Texture texture = random_texture(16, 16, 4);
    for (int i = 0; i < 16 * 16; i += 3) {
      texture.rgba[static_cast<std::size_t>(i) * 4 + 3] = 0;
    }
    const Mesh mesh = quad(texture);
    const Camera camera{241, 233, 500, 480, 117.2, 120.1, {}};
    Renderer renderer(mesh, camera.width, camera.height);
    const Pose pose = pose_at({0, 0, 0.45}, {0.2, 0.2, 0.1});
    const View view = draw(renderer, pose, camera);
    const Comparison comparison = compare(mesh, pose, camera, view);
    check_geometry(comparison);
    CHECK(comparison.color_error <= 2);
    CHECK(comparison.colors > 1000);
    CHECK(10 * comparison.colors < 8 * comparison.surface_pixels);
  }
  SUBCASE("shrunk") {
    // 256 texels on 32 pixels. One texel in 256 was never seen: known, and none of its blue comes through. In the
    // right half every second texel: unknown.
    Texture texture = plain_texture(256, {200, 100, 0, 255});
    const auto hide = [&texture](int column, int row) {
      const std::array<std::uint8_t, 4> unseen = {0, 0, 255, 0};
      std::copy(unseen.begin(), unseen.end(),
                texture.rgba.begin() + (static_cast<std::ptrdiff_t>(row) * 256 + column) * 4);
    };
    for (int row = 0; row < 256; ++row) {
      for (int column = 0; column < 256; ++column) {
        if (column < 128 ? row % 16 == 7 && column % 16 == 5 : (row + column) % 2 == 0) {
          hide(column, row);
        }
      }
    }
    const Mesh mesh = quad(texture);
    const Camera camera{64, 64, 160, 160, 31.5, 31.5, {}};
    Renderer renderer(mesh, 64, 64);
    const View view = draw(renderer, pose_at({0, 0, 1}), camera);
    for (int row = 17; row < 47; ++row) {
      CHECK(view.pixel(20, row)[3] == 255);
      CHECK(view.pixel(20, row)[0] == 200);
      CHECK(view.pixel(20, row)[1] == 100);
      CHECK(view.pixel(20, row)[2] == 0);
      CHECK(view.drawn(43, row));
      CHECK(view.pixel(43, row)[3] == 0);
    }
  }
}

TEST_CASE("A texture is repeated where its coordinates leave the image, and does not bleed around where they do not") {
  const Texture texture = random_texture(9, 6, 12);
  const Camera camera{161, 141, 330, 320, 77.7, 71.2, {}};
  const Pose pose = pose_at({0.01, 0, 0.45}, {0.1, -0.2, 0.1});
  for (const bool repeat : {true, false}) {
    const Mesh mesh = quad(texture, repeat ? 2.5F : 1.0F);
    Renderer renderer(mesh, camera.width, camera.height);
    const Comparison comparison = compare(mesh, pose, camera, draw(renderer, pose, camera), repeat);
    check_geometry(comparison);
    CHECK(comparison.colors > 10000);
    CHECK(comparison.color_error <= 2);
  }
}

TEST_CASE("A model far from its own origin, and one far from the camera, keep their accuracy") {
  Mesh mesh = colored_box();
  const Eigen::Vector3f offset(30, -20, 50);
  for (Eigen::Vector3f& position : mesh.positions) {
    position += offset;
  }
  Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  pose.translation() -= pose.linear() * offset.cast<double>();
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  const Comparison comparison = compare(mesh, pose, kRenderCamera, draw(renderer, pose));
  check_geometry(comparison);
  CHECK(comparison.surface_pixels > 500);

  const Mesh near_mesh = colored_box();
  Renderer near_renderer(near_mesh, kRenderCamera.width, kRenderCamera.height);
  Camera telescope = kRenderCamera;
  telescope.fx *= 100;
  telescope.fy *= 100;
  const Pose far_pose = pose_at({0, 0, 50}, {0.4, 0.9, -0.3});
  const Comparison far_comparison = compare(near_mesh, far_pose, telescope, draw(near_renderer, far_pose, telescope));
  check_geometry(far_comparison);
  CHECK(far_comparison.surface_pixels > 500);
}

}  // namespace holdfast
