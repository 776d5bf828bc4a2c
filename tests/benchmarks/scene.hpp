#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::bench {

struct SceneOptions {
  int width = 512;
  int height = 256;
  double object_pixels = 0.25 * 512 * 256;  ///< of the object's silhouette in the middle pose
  int frames = 48;                          ///< fewer travel a shorter path at the same speed
};

/// Frames in memory of a printed box that moves along a closed path, up to 4 pixels a frame: after the last frame the
/// first follows as any other does, so that a tracker can go round for as long as it is timed.
struct Scene {
  Mesh mesh;
  Camera camera;
  std::vector<Pose> T_camera_object;
  std::vector<cv::Mat> images;  ///< CV_8UC3, BGR

  ImageView frame(std::size_t i) const;
};

Scene make_scene(const SceneOptions& options);

/// The same surface with each triangle cut into `pieces` x `pieces`.
Mesh subdivided(const Mesh& mesh, int pieces);

}  // namespace holdfast::bench
