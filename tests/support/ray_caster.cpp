#include "ray_caster.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace holdfast::test {
namespace {

Eigen::Vector4d texel(const Texture& texture, int column, int row, bool repeat) {
  const auto wrapped = [repeat](int index, int size) {
    return repeat ? ((index % size) + size) % size : std::clamp(index, 0, size - 1);
  };
  const int x = wrapped(column, texture.width);
  const int y = wrapped(row, texture.height);
  const std::uint8_t* rgba = texture.rgba.data() + (static_cast<std::size_t>(y) * texture.width + x) * 4;
  return {double(rgba[0]), double(rgba[1]), double(rgba[2]), double(rgba[3])};
}

Eigen::Vector3d ray(const Camera& camera, const Eigen::Vector2d& pixel) {
  return {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1};
}

}  // namespace

Eigen::Vector4d sample_texture(const Texture& texture, const Eigen::Vector2d& coordinate, bool repeat) {
  const double x = coordinate.x() * texture.width - 0.5;
  const double y = (1 - coordinate.y()) * texture.height - 0.5;
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  const double a = x - column;
  const double b = y - row;
  const Eigen::Vector4d upper =
      (1 - a) * texel(texture, column, row, repeat) + a * texel(texture, column + 1, row, repeat);
  const Eigen::Vector4d lower =
      (1 - a) * texel(texture, column, row + 1, repeat) + a * texel(texture, column + 1, row + 1, repeat);
  return (1 - b) * upper + b * lower;
}

RayCaster::RayCaster(const Mesh& mesh, const Pose& T_camera_object) : mesh_(mesh) {
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) {
      corners_.push_back(T_camera_object * mesh.positions[index].cast<double>());
    }
  }
}

// Moeller and Trumbore: solve a + u edge1 + v edge2 = t direction; t is the depth, for the direction's z is 1.
std::optional<RayHit> RayCaster::meet_plane(std::size_t triangle, const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d& a = corners_[3 * triangle];
  const Eigen::Vector3d edge1 = corners_[3 * triangle + 1] - a;
  const Eigen::Vector3d edge2 = corners_[3 * triangle + 2] - a;
  const Eigen::Vector3d p = direction.cross(edge2);
  const double determinant = edge1.dot(p);
  if (determinant == 0) {
    return std::nullopt;
  }
  const Eigen::Vector3d q = (-a).cross(edge1);
  const double u = (-a).dot(p) / determinant;
  const double v = direction.dot(q) / determinant;
  return RayHit{edge2.dot(q) / determinant, triangle, {1 - u - v, u, v}};
}

std::optional<RayHit> RayCaster::cast(const Camera& camera, const Eigen::Vector2d& pixel, double nearest) const {
  std::optional<RayHit> first;
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const auto hit = meet_plane(i, ray(camera, pixel));
    if (hit && hit->weights.minCoeff() >= 0 && hit->depth > nearest && (!first || hit->depth < first->depth)) {
      first = hit;
    }
  }
  return first;
}

double RayCaster::texels_per_pixel(const Camera& camera, const Eigen::Vector2d& pixel, const RayHit& hit) const {
  const Texture* texture = texture_of(hit.triangle);
  if (texture == nullptr) {
    return 0;
  }
  double largest = 0;
  for (const Eigen::Vector2d& half_step : {Eigen::Vector2d(0.5, 0), Eigen::Vector2d(0, 0.5)}) {
    const auto before = meet_plane(hit.triangle, ray(camera, pixel - half_step));
    const auto after = meet_plane(hit.triangle, ray(camera, pixel + half_step));
    const Eigen::Vector2d step = texture_coordinate(*after) - texture_coordinate(*before);
    largest = std::max(largest, std::hypot(step.x() * texture->width, step.y() * texture->height));
  }
  return largest;
}

const Texture* RayCaster::texture_of(std::size_t triangle) const {
  const std::size_t material = mesh_.triangle_materials.empty() ? 0 : mesh_.triangle_materials[triangle];
  if (mesh_.texture_coordinates.empty() || material >= mesh_.materials.size()) {
    return nullptr;
  }
  const Texture& texture = mesh_.materials[material].texture;
  return texture.empty() ? nullptr : &texture;
}

Eigen::Vector2d RayCaster::texture_coordinate(const RayHit& hit) const {
  Eigen::Vector2d coordinate = Eigen::Vector2d::Zero();
  for (int i = 0; i < 3; ++i) {
    coordinate += hit.weights[i] * mesh_.texture_coordinates[mesh_.triangles[hit.triangle][i]].cast<double>();
  }
  return coordinate;
}

Eigen::Vector4d RayCaster::color(const RayHit& hit, bool repeat) const {
  if (const Texture* texture = texture_of(hit.triangle)) {
    return sample_texture(*texture, texture_coordinate(hit), repeat);
  }
  Eigen::Vector4d color = Eigen::Vector4d::Zero();
  if (!mesh_.colors.empty()) {
    for (int i = 0; i < 3; ++i) {
      for (int channel = 0; channel < 4; ++channel) {
        color[channel] += hit.weights[i] * mesh_.colors[mesh_.triangles[hit.triangle][i]][channel];
      }
    }
  }
  return color;
}

Eigen::Vector4d RayCaster::pixel_color(const Camera& camera, const Eigen::Vector2d& pixel, const RayHit& hit,
                                       bool repeat) const {
  const Texture* texture = texture_of(hit.triangle);
  if (texture == nullptr) {
    return color(hit, repeat);
  }
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const double dx : {-0.25, 0.25}) {
    for (const double dy : {-0.25, 0.25}) {
      const auto sample = meet_plane(hit.triangle, ray(camera, pixel + Eigen::Vector2d(dx, dy)));
      const Eigen::Vector4d value = sample_texture(*texture, texture_coordinate(*sample), repeat);
      for (int channel = 0; channel < 3; ++channel) {
        sum[channel] += 0.25 * value[channel] * value[channel];
      }
      sum[3] += 0.25 * value[3];
    }
  }
  return {std::sqrt(sum[0]), std::sqrt(sum[1]), std::sqrt(sum[2]), sum[3]};
}

}  // namespace holdfast::test
