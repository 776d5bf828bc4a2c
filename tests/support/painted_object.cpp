#include "support/painted_object.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace holdfast::test {
namespace {

/// What is painted on the object: smooth waves, so that sampling them at pixels loses nothing. BGR.
Eigen::Vector3d paint(const Eigen::Vector3d& p_object) {
  const Eigen::Vector3d waves(std::sin(70 * p_object.x() + 40 * p_object.z()), std::sin(55 * p_object.y() + 1.0),
                              std::cos(50 * p_object.z() - 45 * p_object.x() + 30 * p_object.y()));
  return Eigen::Vector3d(120, 130, 110) + 70 * waves;
}

/// The pixel of the ideal frame that lens distortion puts at `recorded`.
Eigen::Vector2d undistorted(const Camera& camera, const Eigen::Vector2d& recorded) {
  Eigen::Vector2d pixel = recorded;
  for (int i = 0; i < 50; ++i) {
    pixel += recorded - camera.distort(pixel);
  }
  return pixel;
}

Eigen::Vector3d point_of(const Mesh& mesh, const RayHit& hit) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    p += hit.weights[k] * mesh.positions[mesh.triangles[hit.triangle][static_cast<std::size_t>(k)]].cast<double>();
  }
  return p;
}

Eigen::Vector3d normal_of(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Eigen::Vector3f p = mesh.positions[a];
  return (mesh.positions[b] - p).cross(mesh.positions[c] - p).cast<double>().normalized();
}

}  // namespace

void add_box(Mesh& mesh, const Eigen::Vector3f& center, const Eigen::Vector3f& size) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(center + 0.5F * Eigen::Vector3f((i & 1) != 0 ? size.x() : -size.x(),
                                                             (i & 2) != 0 ? size.y() : -size.y(),
                                                             (i & 4) != 0 ? size.z() : -size.z()));
  }
  for (const auto& [a, b, c] : {std::array<std::uint32_t, 3>{0, 2, 1},
                                {1, 2, 3},
                                {4, 5, 6},
                                {5, 7, 6},
                                {0, 1, 4},
                                {1, 5, 4},
                                {2, 6, 3},
                                {3, 6, 7},
                                {0, 4, 2},
                                {2, 4, 6},
                                {1, 3, 5},
                                {3, 7, 5}}) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

Mesh one_box() {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {0.16F, 0.12F, 0.1F});
  return mesh;
}

Mesh two_boxes() {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {0.08F, 0.16F, 0.12F});
  add_box(mesh, {0.09F, 0.01F, 0.01F}, {0.03F, 0.05F, 0.04F});
  return mesh;
}

Eigen::Vector3d as_it_is(const Eigen::Vector3d& color, const Eigen::Vector3d& /*normal*/) { return color; }

cv::Mat photograph(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object, const Light& light,
                   const cv::Vec3b& background) {
  const RayCaster caster(mesh, T_camera_object);
  cv::Mat frame(camera.height, camera.width, CV_8UC3, background);
  for (int y = 0; y < frame.rows; ++y) {
    for (int x = 0; x < frame.cols; ++x) {
      const Eigen::Vector2d recorded(x, y);
      const auto hit = caster.cast(camera, camera.has_distortion() ? undistorted(camera, recorded) : recorded);
      if (hit) {
        const Eigen::Vector3d color = light(paint(point_of(mesh, *hit)), normal_of(mesh, hit->triangle));
        for (int c = 0; c < 3; ++c) {
          frame.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(color[c]);
        }
      }
    }
  }
  return frame;
}

Pose look(double yaw, double pitch, const Eigen::Vector3d& p_camera) {
  Eigen::Matrix3d upright;  // object z up, x towards the camera
  upright << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()).toRotationMatrix() * upright *
                  Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = p_camera;
  return pose;
}

baking::TextureOptions texture_options() {
  baking::TextureOptions options;
  options.texels_per_metre = 700;
  return options;
}

std::vector<Texel> surface_texels(const Mesh& mesh) {
  std::vector<Texel> texels;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[t];
    const Texture& texture = mesh.materials[material].texture;
    Eigen::Matrix3d corners;  // columns: x, y in texels, 1
    Eigen::Matrix3d positions;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[t][static_cast<std::size_t>(k)];
      const Eigen::Vector2d coordinate = mesh.texture_coordinates[vertex].cast<double>();
      corners.col(k) =
          Eigen::Vector3d(coordinate.x() * texture.width - 0.5, (1 - coordinate.y()) * texture.height - 0.5, 1);
      positions.col(k) = mesh.positions[vertex].cast<double>();
    }
    const Eigen::Matrix3d weights_of = corners.inverse();
    for (int y = 0; y < texture.height; ++y) {
      for (int x = 0; x < texture.width; ++x) {
        const Eigen::Vector3d weights = weights_of * Eigen::Vector3d(x, y, 1);
        if (weights.minCoeff() > 1e-4) {
          const std::size_t index = static_cast<std::size_t>(y) * texture.width + x;
          const std::uint8_t* rgba = texture.rgba.data() + 4 * index;
          texels.push_back({positions * weights, normal_of(mesh, t), {rgba[0], rgba[1], rgba[2], rgba[3]}, index});
        }
      }
    }
  }
  return texels;
}

double error_of_texel(const Texel& texel) {
  const Eigen::Vector3d truth = paint(texel.p_object);
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    largest = std::max(largest, std::abs(texel.rgba[static_cast<std::size_t>(2 - c)] - truth[c]));
  }
  return largest;
}

Sight sight_of(const RayCaster& caster, const Camera& camera, const Pose& T_camera_object, const Texel& texel,
               double radius) {
  const Eigen::Vector3d p_camera = T_camera_object * texel.p_object;
  const Eigen::Vector2d pixel = camera.project(p_camera);
  const auto hit = caster.cast(camera, pixel);
  if (!hit || std::abs(hit->depth - p_camera.z()) > 1e-4) {
    return Sight::hidden;
  }
  if (pixel.x() < radius || pixel.y() < radius || pixel.x() > camera.width - 1 - radius ||
      pixel.y() > camera.height - 1 - radius) {
    return Sight::near_border;
  }
  for (int k = 0; k < 16; ++k) {
    const double angle = k * std::numbers::pi / 8;
    for (const double share : {0.5, 1.0}) {
      const auto near = caster.cast(camera, pixel + share * radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      if (!near || std::abs(near->depth - p_camera.z()) > 0.05 * p_camera.z()) {
        return Sight::near_border;
      }
    }
  }
  return Sight::clear;
}

}  // namespace holdfast::test
