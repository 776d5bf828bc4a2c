#include "scene.hpp"

#include <cmath>
#include <numbers>

#include "simulation/rasterizer.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"

namespace holdfast::bench {
namespace {

/// Distance at which the object's silhouette has this many pixels.
double distance_for(double object_pixels, const Mesh& mesh, const Camera& camera) {
  const simulation::DrawnMesh drawn(mesh);
  // Drawn in a frame that the whole silhouette fits in, whatever the camera's own frame cuts off.
  Camera wide = camera;
  wide.width = wide.height = 2048;
  wide.cx = wide.cy = 1023.5;
  double distance = 0.8;
  for (int i = 0; i < 4; ++i) {
    simulation::Scene scene;
    scene.object.mesh = &drawn;
    scene.object.T_camera_object.linear() = simulation::MotionOptions::default_orientation();
    scene.object.T_camera_object.translation().z() = distance;
    const auto pixels = static_cast<double>(simulation::draw(scene, wide, 1, false).object_samples);
    distance *= std::sqrt(pixels / object_pixels);
  }
  return distance;
}

}  // namespace

ImageView Scene::frame(std::size_t i) const {
  const cv::Mat& image = images[i];
  return {image.data, image.cols, image.rows, image.step, PixelFormat::bgr8};
}

Scene make_scene(const SceneOptions& options) {
  Scene scene;
  scene.mesh = simulation::textured_box();
  const double focal = 650;
  scene.camera = {
      options.width, options.height, focal, focal, 0.5 * (options.width - 1), 0.5 * (options.height - 1), {}};
  const double z = distance_for(options.object_pixels, scene.mesh, scene.camera);

  simulation::SequenceOptions sequence;
  sequence.camera = scene.camera;
  sequence.frames = options.frames;
  sequence.samples = 2;
  sequence.sensor.blur_sigma = 0.5;
  sequence.sensor.noise = 2;
  const double pixel = z / focal;  // metres at the object's distance
  const double path = options.frames / 48.0;
  for (int i = 0; i < options.frames; ++i) {
    const double phase = 2 * std::numbers::pi * i / options.frames;
    const Eigen::Vector3d turn =
        path * Eigen::Vector3d(0.06 * std::sin(phase + 1), 0.06 * std::sin(phase + 2), 0.03 * std::sin(phase + 3));
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() *
                    simulation::MotionOptions::default_orientation();
    pose.translation() = Eigen::Vector3d(path * 20 * pixel * std::cos(phase), path * 5 * pixel * std::sin(2 * phase),
                                         z * (1 + path * 0.03 * std::sin(phase)));
    sequence.motion.T_camera_object.push_back(pose);
  }
  const simulation::Sequence frames(scene.mesh, sequence);
  scene.T_camera_object = frames.poses();
  for (int i = 0; i < options.frames; ++i) scene.images.push_back(frames.frame(i));
  return scene;
}

Mesh subdivided(const Mesh& mesh, int pieces) {
  Mesh fine = mesh;
  fine.positions.clear();
  fine.texture_coordinates.clear();
  fine.triangles.clear();
  fine.triangle_materials.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto first = static_cast<std::uint32_t>(fine.positions.size());
    const auto index = [&](int row, int column) {
      return first + static_cast<std::uint32_t>(row * (row + 1) / 2 + column);
    };
    for (int row = 0; row <= pieces; ++row) {
      for (int column = 0; column <= row; ++column) {
        const float v = static_cast<float>(row - column) / static_cast<float>(pieces);
        const float w = static_cast<float>(column) / static_cast<float>(pieces);
        const float u = 1.0f - v - w;
        fine.positions.push_back(u * mesh.positions[a] + v * mesh.positions[b] + w * mesh.positions[c]);
        fine.texture_coordinates.push_back(u * mesh.texture_coordinates[a] + v * mesh.texture_coordinates[b] +
                                           w * mesh.texture_coordinates[c]);
      }
    }
    for (int row = 0; row < pieces; ++row) {
      for (int column = 0; column <= row; ++column) {
        fine.triangles.push_back({index(row, column), index(row + 1, column), index(row + 1, column + 1)});
        if (column < row) {
          fine.triangles.push_back({index(row, column), index(row + 1, column + 1), index(row, column + 1)});
        }
      }
    }
    if (!mesh.triangle_materials.empty())
      fine.triangle_materials.resize(fine.triangles.size(), mesh.triangle_materials[t]);
  }
  return fine;
}

}  // namespace holdfast::bench
