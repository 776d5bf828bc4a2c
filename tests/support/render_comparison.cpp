#include "support/render_comparison.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "support/ray_caster.hpp"

namespace holdfast::test {

View draw(Renderer& renderer, const Pose& pose, const Camera& camera, const Rect& roi) {
  View view;
  view.roi = roi;
  const std::size_t pixels = static_cast<std::size_t>(roi.width) * roi.height;
  view.rgba.assign(pixels * 4, 77);
  view.window_depth.assign(pixels, -1.0F);
  view.range = renderer.render(pose, camera, roi, {view.rgba.data(), view.window_depth.data(), 0});
  return view;
}

View draw(Renderer& renderer, const Pose& pose, const Camera& camera) {
  return draw(renderer, pose, camera, {0, 0, camera.width, camera.height});
}

Comparison compare(const Mesh& mesh, const Pose& pose, const Camera& camera, const View& view, bool repeat,
                   int texture_samples) {
  Comparison result;
  const RayCaster caster(mesh, pose);
  for (int row = 0; row < view.roi.height; ++row) {
    for (int column = 0; column < view.roi.width; ++column) {
      ++result.pixels;
      const Eigen::Vector2d center(view.roi.x + column, view.roi.y + row);
      const auto hit = caster.cast(camera, center, view.range.near_plane);
      bool mask_stable = true;
      bool surface_stable = true;
      double nearest = hit ? hit->depth : 0, farthest = nearest;
      for (int k = 0; k < 8; ++k) {
        const double angle = k * std::numbers::pi / 4;
        const auto other = caster.cast(camera, center + 0.01 * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                                       view.range.near_plane);
        mask_stable = mask_stable && hit.has_value() == other.has_value();
        surface_stable = surface_stable && hit && other && hit->triangle == other->triangle;
        if (!other) continue;
        nearest = std::min(nearest, other->depth);
        farthest = std::max(farthest, other->depth);
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
      const double depth = view.depth(column, row);
      result.depth_error = std::max({result.depth_error, 1 - depth / nearest, depth / farthest - 1});
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

Mesh quad(const Texture& texture, float repeats) {
  Mesh mesh;
  mesh.positions = {{-0.1F, -0.1F, 0}, {0.1F, -0.1F, 0}, {0.1F, 0.1F, 0}, {-0.1F, 0.1F, 0}};
  mesh.texture_coordinates = {{0, repeats}, {repeats, repeats}, {repeats, 0}, {0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {{"surface", texture}};
  return mesh;
}

Mesh colored_box() {
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
        mesh.colors.push_back({static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
                               static_cast<std::uint8_t>(random()), 255});
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

Pose pose_at(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  if (rotation.norm() > 0) {
    pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  }
  return pose;
}

}  // namespace holdfast::test
