#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "closed_surface.hpp"
#include "holdfast/error.hpp"
#include "holdfast/renderer.hpp"
#include "support/allocation_counter.hpp"
#include "support/ray_caster.hpp"

namespace holdfast {
namespace {

using test::RayCaster;
using test::RayHit;

struct View {
  Rect roi;
  std::vector<std::uint8_t> rgba;
  std::vector<float> window_depth;
  DepthRange range;

  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * roi.width + column; }
  bool drawn(int column, int row) const { return window_depth[index(column, row)] < 1; }
  double depth(int column, int row) const {
    const double n = range.near_plane;
    const double f = range.far_plane;
    return n * f / (f - window_depth[index(column, row)] * (f - n));
  }
  const std::uint8_t* pixel(int column, int row) const { return rgba.data() + 4 * index(column, row); }
  long drawn_count() const {
    return std::count_if(window_depth.begin(), window_depth.end(), [](float depth) { return depth < 1; });
  }
  long known_count() const {
    long count = 0;
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
      count += rgba[i] == 255 ? 1 : 0;
    }
    return count;
  }
};

View draw(Renderer& renderer, const Pose& pose, const Camera& camera, const Rect& roi) {
  View view;
  view.roi = roi;
  const std::size_t pixels = static_cast<std::size_t>(roi.width) * roi.height;
  view.rgba.assign(pixels * 4, 77);
  view.window_depth.assign(pixels, -1.0F);
  view.range = renderer.render(pose, camera, roi, {view.rgba.data(), view.window_depth.data(), 0});
  return view;
}

Rect whole(const Camera& camera) { return {0, 0, camera.width, camera.height}; }

/// A view against the ray caster. Pixels whose centre lies within 0.01 px of an edge (rays 0.01 px away see something
/// else) are left out; `compared` says how many remain.
struct Comparison {
  long pixels = 0;
  long compared = 0;        ///< of the mask
  long mask_errors = 0;     ///< among these
  long surface_pixels = 0;  ///< on a triangle, off its edges
  long known = 0;           ///< of these, with a known colour
  long colors = 0;          ///< of these, with a magnified texture
  long alpha_errors = 0;
  double depth_error = 0;  ///< relative, largest
  double color_error = 0;  ///< grey levels, largest
};

Comparison compare(const Mesh& mesh, const Pose& pose, const Camera& camera, const View& view, bool repeat = false,
                   int texture_samples = 4) {
  Comparison result;
  const RayCaster caster(mesh, pose);
  for (int row = 0; row < view.roi.height; ++row) {
    for (int column = 0; column < view.roi.width; ++column) {
      ++result.pixels;
      const Eigen::Vector2d center(view.roi.x + column, view.roi.y + row);
      const auto hit = caster.cast(camera, center, view.range.near_plane);
      bool mask_stable = true;
      bool surface_stable = true;
      for (int k = 0; k < 8; ++k) {
        const double angle = k * std::numbers::pi / 4;
        const auto other = caster.cast(camera, center + 0.01 * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                                       view.range.near_plane);
        mask_stable = mask_stable && hit.has_value() == other.has_value();
        surface_stable = surface_stable && hit && other && hit->triangle == other->triangle;
      }
      if (!mask_stable) {
        continue;
      }
      ++result.compared;
      if (view.drawn(column, row) != hit.has_value()) {
        ++result.mask_errors;
        continue;
      }
      const std::uint8_t* pixel = view.pixel(column, row);
      if (!hit) {
        result.alpha_errors += pixel[3] == 0 ? 0 : 1;
        continue;
      }
      if (!surface_stable) {
        continue;
      }
      ++result.surface_pixels;
      result.depth_error = std::max(result.depth_error, std::abs(view.depth(column, row) / hit->depth - 1));
      const Eigen::Vector4d color =
          texture_samples == 1 ? caster.color(*hit, repeat) : caster.pixel_color(camera, center, *hit, repeat);
      const double threshold = 0.98 * 255;
      if (std::abs(color[3] - threshold) > 2) {  // the renderer filters alpha in 8 bits
        result.alpha_errors += pixel[3] == (color[3] > threshold ? 255 : 0) ? 0 : 1;
      }
      result.known += pixel[3] == 255 ? 1 : 0;
      // A face seen at a grazing angle is shrunk, which the ray caster does not do.
      if (pixel[3] == 255 && caster.texels_per_pixel(camera, center, *hit) < 0.9) {
        ++result.colors;
        for (int channel = 0; channel < 3; ++channel) {
          result.color_error = std::max(result.color_error, std::abs(pixel[channel] - color[channel]));
        }
      }
    }
  }
  return result;
}

void check_geometry(const Comparison& comparison) {
  CHECK(comparison.mask_errors == 0);
  CHECK(comparison.alpha_errors == 0);
  CHECK(comparison.depth_error < 1e-5);
  CHECK(100 * comparison.compared > 99 * comparison.pixels);
}

Texture random_texture(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Texture texture{width, height, {}};
  texture.rgba.resize(static_cast<std::size_t>(width) * height * 4);
  for (std::size_t i = 0; i < texture.rgba.size(); ++i) {
    texture.rgba[i] = i % 4 == 3 ? std::uint8_t{255} : static_cast<std::uint8_t>(random());
  }
  return texture;
}

Texture plain_texture(int size, const std::array<std::uint8_t, 4>& color) {
  Texture texture{size, size, {}};
  texture.rgba.resize(static_cast<std::size_t>(size) * size * 4);
  for (std::size_t i = 0; i < texture.rgba.size(); ++i) {
    texture.rgba[i] = color[i % 4];
  }
  return texture;
}

/// 0.2 m square in the plane Z = 0, its top (v = 1) towards -y, which is up in the image at the identity rotation.
Mesh quad(const Texture& texture, float repeats = 1) {
  Mesh mesh;
  mesh.positions = {{-0.1F, -0.1F, 0}, {0.1F, -0.1F, 0}, {0.1F, 0.1F, 0}, {-0.1F, 0.1F, 0}};
  mesh.texture_coordinates = {{0, repeats}, {repeats, repeats}, {repeats, 0}, {0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {{"surface", texture}};
  return mesh;
}

/// A box whose six faces have two textured materials, one without texture, and vertex colours.
Mesh box(bool colored = true) {
  const std::array<float, 3> half = {0.10F, 0.06F, 0.04F};
  std::mt19937 random(5);
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        const float s = (corner & 1) != 0 ? 1.0F : -1.0F;
        const float t = (corner & 2) != 0 ? 1.0F : -1.0F;
        Eigen::Vector3f position;
        position[axis] = static_cast<float>(side) * half[axis];
        position[(axis + 1) % 3] = s * half[(axis + 1) % 3];
        position[(axis + 2) % 3] = t * half[(axis + 2) % 3];
        mesh.positions.push_back(position);
        mesh.texture_coordinates.push_back({(s + 1) / 2, (t + 1) / 2});
        if (colored) {
          mesh.colors.push_back({static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
                                 static_cast<std::uint8_t>(random()), 255});
        }
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first + 1, first + 3, first + 2});
      const auto material = static_cast<std::uint32_t>((axis + (side + 1) / 2) % 3);
      mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
    }
  }
  mesh.materials = {{"first", random_texture(8, 5, 1)}, {"none", {}}, {"third", random_texture(7, 8, 2)}};
  return mesh;
}

/// The same box with all fronts outwards.
Mesh outward_box() {
  Mesh mesh = box();
  for (auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.positions[triangle[i]]; };
    const Eigen::Vector3f normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (normal.dot(corner(0)) < 0) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

Pose pose_at(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation = Eigen::Vector3d::Zero()) {
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  if (rotation.norm() > 0) {
    pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  }
  return pose;
}

// Odd size, fx != fy, principal point off the centre.
const Camera kCamera{147, 101, 190.3, 214.7, 61.37, 58.81, {}};

ErrorCode code_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.code();
  }
  FAIL("no error was thrown");
  return ErrorCode::file;
}

}  // namespace

TEST_CASE("A box with several materials agrees with the ray caster from all sides") {
  const Mesh mesh = box();
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 12; ++i) {
    const Pose pose = pose_at({0.03 * normal(random), 0.02 * normal(random), 0.5 + 0.03 * normal(random)},
                              {2 * normal(random), 2 * normal(random), 2 * normal(random)});
    CAPTURE(i);
    const Comparison comparison = compare(mesh, pose, kCamera, draw(renderer, pose, kCamera, whole(kCamera)));
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
  CHECK_FALSE(is_closed_outward(box()));  // some of its faces look inwards
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

  Renderer renderer(closed, kCamera.width, kCamera.height), inside_too(open, kCamera.width, kCamera.height);
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    const Eigen::Vector3d rotation(2 * normal(random), 2 * normal(random), 2 * normal(random));
    const Pose pose = pose_at({0.0, 0.01, 0.5}, rotation);
    const Comparison comparison = compare(closed, pose, kCamera, draw(renderer, pose, kCamera, whole(kCamera)));
    check_geometry(comparison);
    CHECK(comparison.surface_pixels > 500);
    // Cut open by the near plane, the inside shows; depths that close to the camera are coarse.
    const Pose around = pose_at({0.0, 0.01, 0.03}, rotation);
    const Comparison cut = compare(closed, around, kCamera, draw(renderer, around, kCamera, whole(kCamera)));
    CHECK(cut.mask_errors == 0);
    CHECK(cut.alpha_errors == 0);
    CHECK(cut.depth_error < 1e-3);
    check_geometry(compare(open, pose, kCamera, draw(inside_too, pose, kCamera, whole(kCamera))));
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
      const View view = draw(renderer, pose, camera, whole(camera));
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
  const View view = draw(renderer, pose, camera, whole(camera));
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
  const View view = draw(renderer, pose_at({0, 0, 1}), camera, whole(camera));
  CHECK(view.pixel(14, 14)[0] == 255);
  CHECK(view.pixel(49, 14)[1] == 255);
  CHECK(view.pixel(14, 49)[2] == 255);
  CHECK(view.pixel(49, 49)[0] + view.pixel(49, 49)[1] + view.pixel(49, 49)[2] == 0);
}

TEST_CASE("A region of the view, also partly or wholly outside the frame, is that part of the view") {
  const Mesh mesh = box();
  Renderer renderer(mesh, 160, 130);
  const Pose pose = pose_at({-0.10, 0.03, 0.42}, {0.4, 0.9, -0.3});
  for (const Rect& roi : {Rect{11, 23, 67, 45}, Rect{-31, -17, 97, 88}, Rect{100, 60, 77, 69}, Rect{-45, 20, 41, 64},
                          Rect{30, 40, 1, 1}}) {
    CAPTURE(roi.x);
    const Comparison comparison = compare(mesh, pose, kCamera, draw(renderer, pose, kCamera, roi));
    check_geometry(comparison);
    CHECK(comparison.color_error <= 2);
    if (roi.x != 100) {
      CHECK(comparison.surface_pixels > 0);
    }
  }
}

TEST_CASE("Rows are written at the target's stride and nothing between them is touched; either buffer may be absent") {
  const Mesh mesh = box();
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  const Rect roi{20, 10, 83, 71};
  const View packed = draw(renderer, pose, kCamera, roi);
  const int stride = 96;
  for (const bool in_front : {true, false}) {
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(stride) * roi.height * 4, 77);
    std::vector<float> depth(static_cast<std::size_t>(stride) * roi.height, -7.0F);
    renderer.render(in_front ? pose : pose_at({0, 0, -0.5}), kCamera, roi, {rgba.data(), depth.data(), stride});
    long wrong = 0;
    for (int row = 0; row < roi.height; ++row) {
      for (int column = 0; column < stride; ++column) {
        const std::size_t i = static_cast<std::size_t>(row) * stride + column;
        if (column >= roi.width) {
          wrong += rgba[4 * i] == 77 && rgba[4 * i + 3] == 77 && depth[i] == -7.0F ? 0 : 1;
        } else if (in_front) {
          wrong += std::equal(&rgba[4 * i], &rgba[4 * i] + 4, packed.pixel(column, row)) ? 0 : 1;
          wrong += depth[i] == packed.window_depth[packed.index(column, row)] ? 0 : 1;
        } else {
          wrong += rgba[4 * i] == 0 && rgba[4 * i + 3] == 0 && depth[i] == 1.0F ? 0 : 1;
        }
      }
    }
    CHECK(wrong == 0);
  }
  std::vector<std::uint8_t> rgba(packed.rgba.size());
  std::vector<float> depth(packed.window_depth.size());
  renderer.render(pose, kCamera, roi, {rgba.data(), nullptr, 0});
  renderer.render(pose, kCamera, roi, {nullptr, depth.data(), 0});
  CHECK(rgba == packed.rgba);
  CHECK(depth == packed.window_depth);
}

TEST_CASE("An object behind the camera is not drawn, one partly behind it is cut at the near plane") {
  const Mesh mesh = box();
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  const View behind = draw(renderer, pose_at({0, 0, -0.5}), kCamera, whole(kCamera));
  CHECK(behind.drawn_count() == 0);
  CHECK(std::all_of(behind.rgba.begin(), behind.rgba.end(), [](std::uint8_t value) { return value == 0; }));
  CHECK(std::all_of(behind.window_depth.begin(), behind.window_depth.end(), [](float depth) { return depth == 1; }));
  CHECK(behind.range.near_plane > 0);
  CHECK(behind.range.far_plane > behind.range.near_plane);

  // The camera inside the box, and the box's long axis running past the camera.
  for (const Pose& pose :
       {pose_at({0.01, 0.02, 0.01}, {0.2, 0.1, 0.3}), pose_at({0.08, 0.05, 0.03}, {0.1, 1.4, 0.2})}) {
    const View view = draw(renderer, pose, kCamera, whole(kCamera));
    CHECK(view.range.near_plane > 0);
    CHECK(view.range.near_plane < 0.01 * view.range.far_plane);
    const Comparison comparison = compare(mesh, pose, kCamera, view);
    CHECK(comparison.surface_pixels > 500);
    CHECK(comparison.mask_errors == 0);
    CHECK(comparison.alpha_errors == 0);
    // A near plane at 1/1000 of the far plane costs digits: 1000 times the rounding of a float in [0.5, 1].
    CHECK(comparison.depth_error < 1e-4);
  }
}

TEST_CASE("Vertex colours are interpolated in perspective; without colours a surface is drawn but unknown") {
  Mesh mesh = box();
  mesh.materials.clear();
  mesh.triangle_materials.clear();
  const Pose pose = pose_at({0.01, -0.02, 0.45}, {0.5, 0.6, 0.2});
  {
    Renderer renderer(mesh, kCamera.width, kCamera.height);
    const Comparison comparison = compare(mesh, pose, kCamera, draw(renderer, pose, kCamera, whole(kCamera)));
    check_geometry(comparison);
    CHECK(comparison.colors == comparison.surface_pixels);
    CHECK(comparison.colors > 500);
    CHECK(comparison.color_error <= 1);
  }
  mesh.colors.clear();
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  const View view = draw(renderer, pose, kCamera, whole(kCamera));
  const Comparison comparison = compare(mesh, pose, kCamera, view);
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
  const View view = draw(renderer, pose_at({0, 0, 0.5}), camera, whole(camera));
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
    const View view = draw(renderer, pose, camera, whole(camera));
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
    const View view = draw(renderer, pose_at({0, 0, 1}), camera, whole(camera));
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
    const Comparison comparison = compare(mesh, pose, camera, draw(renderer, pose, camera, whole(camera)), repeat);
    check_geometry(comparison);
    CHECK(comparison.colors > 10000);
    CHECK(comparison.color_error <= 2);
  }
}

TEST_CASE("Two renderers live beside each other, and the end of one leaves the other alone") {
  const Mesh mesh = box();
  const Mesh other_mesh = quad(random_texture(8, 8, 3));
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  auto first = std::make_unique<Renderer>(mesh, kCamera.width, kCamera.height);
  const View alone = draw(*first, pose, kCamera, whole(kCamera));
  CHECK(alone.drawn_count() > 500);

  auto second = std::make_unique<Renderer>(other_mesh, kCamera.width, kCamera.height);
  const View other = draw(*second, pose, kCamera, whole(kCamera));
  CHECK(other.window_depth != alone.window_depth);
  const View between = draw(*first, pose, kCamera, whole(kCamera));
  CHECK(between.rgba == alone.rgba);
  CHECK(between.window_depth == alone.window_depth);

  second.reset();
  const View after = draw(*first, pose, kCamera, whole(kCamera));
  CHECK(after.rgba == alone.rgba);
  CHECK(after.window_depth == alone.window_depth);

  second = std::make_unique<Renderer>(other_mesh, kCamera.width, kCamera.height);
  first.reset();
  const View survivor = draw(*second, pose, kCamera, whole(kCamera));
  CHECK(survivor.rgba == other.rgba);
}

TEST_CASE("A renderer works from any thread, and several threads may each use their own") {
  const Mesh mesh = box();
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  auto renderer = std::make_unique<Renderer>(mesh, kCamera.width, kCamera.height);
  const View here = draw(*renderer, pose, kCamera, whole(kCamera));
  View there;
  std::thread([&] { there = draw(*renderer, pose, kCamera, whole(kCamera)); }).join();
  CHECK(there.rgba == here.rgba);
  CHECK(there.window_depth == here.window_depth);
  const View back = draw(*renderer, pose, kCamera, whole(kCamera));
  CHECK(back.rgba == here.rgba);

  std::atomic<int> wrong{0};
  const auto work = [&] {
    Renderer own(mesh, kCamera.width, kCamera.height);
    for (int i = 0; i < 20; ++i) {
      wrong += draw(own, pose, kCamera, whole(kCamera)).rgba == here.rgba ? 0 : 1;
    }
  };
  std::thread one(work);
  std::thread two(work);
  one.join();
  two.join();
  CHECK(wrong == 0);

  std::thread([&] { renderer.reset(); }).join();
  Renderer later(mesh, kCamera.width, kCamera.height);
  CHECK(draw(later, pose, kCamera, whole(kCamera)).rgba == here.rgba);
}

TEST_CASE("A texture can be replaced by one of the same or another size, taken away and given back") {
  Mesh mesh = quad(random_texture(8, 8, 1));
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  const Pose pose = pose_at({0, 0, 0.5}, {0.2, 0.3, 0.1});
  for (const Texture& texture :
       {random_texture(8, 8, 2), random_texture(5, 13, 3), Texture{}, random_texture(6, 6, 4)}) {
    renderer.set_texture(0, texture);
    mesh.materials[0].texture = texture;
    const Comparison comparison = compare(mesh, pose, kCamera, draw(renderer, pose, kCamera, whole(kCamera)));
    check_geometry(comparison);
    CHECK(comparison.surface_pixels > 500);
    CHECK(comparison.colors == (texture.empty() ? 0 : comparison.surface_pixels));
    CHECK(comparison.color_error <= 2);
  }
}

TEST_CASE("A model far from its own origin, and one far from the camera, keep their accuracy") {
  Mesh mesh = box();
  const Eigen::Vector3f offset(30, -20, 50);
  for (Eigen::Vector3f& position : mesh.positions) {
    position += offset;
  }
  Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  pose.translation() -= pose.linear() * offset.cast<double>();
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  const Comparison comparison = compare(mesh, pose, kCamera, draw(renderer, pose, kCamera, whole(kCamera)));
  check_geometry(comparison);
  CHECK(comparison.surface_pixels > 500);

  const Mesh near_mesh = box();
  Renderer near_renderer(near_mesh, kCamera.width, kCamera.height);
  Camera telescope = kCamera;
  telescope.fx *= 100;
  telescope.fy *= 100;
  const Pose far_pose = pose_at({0, 0, 50}, {0.4, 0.9, -0.3});
  const Comparison far_comparison =
      compare(near_mesh, far_pose, telescope, draw(near_renderer, far_pose, telescope, whole(kCamera)));
  check_geometry(far_comparison);
  CHECK(far_comparison.surface_pixels > 500);
}

TEST_CASE("The same view twice has the same bits, and drawing it allocates nothing") {
  const Mesh mesh = box();
  Renderer renderer(mesh, 640, 480);
  const Camera camera{640, 480, 700, 710, 310, 250, {}};
  const std::array<Rect, 3> rois = {Rect{0, 0, 640, 480}, Rect{200, 150, 200, 130}, Rect{300, 200, 60, 50}};
  const std::array<Pose, 2> poses = {pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3}), pose_at({0, 0, -0.5})};
  std::vector<std::uint8_t> rgba(640 * 480 * 4);
  std::vector<float> depth(640 * 480);
  for (const Rect& roi : rois) {
    renderer.render(poses[0], camera, roi, {rgba.data(), depth.data(), 640});
  }
  const long before = test::operator_new_count();
  for (int i = 0; i < 10; ++i) {
    for (const Rect& roi : rois) {
      for (const Pose& pose : poses) {
        renderer.render(pose, camera, roi, {rgba.data(), depth.data(), 640});
      }
    }
  }
  CHECK(test::operator_new_count() == before);

  const View one = draw(renderer, poses[0], camera, rois[0]);
  const View two = draw(renderer, poses[0], camera, rois[0]);
  CHECK(one.rgba == two.rgba);
  CHECK(one.window_depth == two.window_depth);
}

TEST_CASE("The first frame does not pay for compiling: construction has drawn once") {
  const Mesh mesh = box();
  Renderer renderer(mesh, 64, 64);
  std::vector<std::uint8_t> rgba(64 * 64 * 4);
  std::vector<float> depth(64 * 64);
  const Camera camera{64, 64, 80, 80, 31, 31, {}};
  const long before = test::operator_new_count();
  renderer.render(pose_at({0, 0, 0.5}), camera, {0, 0, 64, 64}, {rgba.data(), depth.data(), 64});
  CHECK(test::operator_new_count() == before);
}

TEST_CASE("Misuse is an error with its code") {
  const Mesh mesh = box();
  Renderer renderer(mesh, 100, 80);
  std::vector<std::uint8_t> rgba(200 * 200 * 4);
  std::vector<float> depth(200 * 200);
  const RenderTarget target{rgba.data(), depth.data(), 0};
  const Pose pose = pose_at({0, 0, 0.5});
  CHECK(code_of([&] { renderer.render(pose, kCamera, {0, 0, 101, 80}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.render(pose, kCamera, {0, 0, 100, 81}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.render(pose, kCamera, {0, 0, 0, 10}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] {
          renderer.render(pose, kCamera, {0, 0, 50, 50}, {rgba.data(), depth.data(), 49});
        }) == ErrorCode::invalid_argument);
  Pose broken = pose;
  broken.translation().x() = std::nan("");
  CHECK(code_of([&] { renderer.render(broken, kCamera, {0, 0, 50, 50}, target); }) == ErrorCode::pose);

  CHECK(code_of([&] { renderer.set_texture(3, random_texture(4, 4, 1)); }) == ErrorCode::invalid_argument);
  Texture short_texture = random_texture(4, 4, 1);
  short_texture.rgba.pop_back();
  CHECK(code_of([&] { renderer.set_texture(0, short_texture); }) == ErrorCode::invalid_argument);
  Texture negative = random_texture(4, 4, 1);
  negative.width = negative.height = -4;
  CHECK(code_of([&] { renderer.set_texture(0, negative); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.set_texture(0, random_texture(20000, 1, 1)); }) == ErrorCode::model);
  CHECK(draw(renderer, pose, kCamera, {20, 20, 64, 64}).known_count() > 500);

  CHECK(code_of([] { Renderer(Mesh{}, 64, 64); }) == ErrorCode::model);
  CHECK(code_of([] { Renderer(quad(random_texture(20000, 1, 1)), 64, 64); }) == ErrorCode::model);
  CHECK(code_of([&] { Renderer(mesh, 0, 64); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { Renderer(mesh, 64, 64, {3}); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { Renderer(mesh, 64, 1 << 20); }) == ErrorCode::invalid_argument);
  Mesh bare = quad({});
  bare.texture_coordinates.clear();
  Renderer bare_renderer(bare, 64, 64);
  CHECK(code_of([&] { bare_renderer.set_texture(0, random_texture(4, 4, 1)); }) == ErrorCode::invalid_argument);
}

TEST_CASE("The description names OSMesa's renderer") {
  Renderer renderer(box(), 64, 64);
  CHECK(renderer.description().find("pipe") != std::string::npos);
  CHECK(renderer.description().find("OpenGL") != std::string::npos);
  Renderer moved = std::move(renderer);
  CHECK(draw(moved, pose_at({0, 0, 0.5}), kCamera, {20, 20, 64, 64}).drawn_count() > 500);
}

}  // namespace holdfast
