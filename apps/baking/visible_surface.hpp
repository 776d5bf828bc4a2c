#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::baking {

/// Which points of a mesh a camera sees, away from the borders at which a small error of pose or shape would show
/// something else.
class VisibleSurface {
 public:
  /// Throws Error(renderer, model).
  VisibleSurface(const Mesh& mesh, const Camera& camera);

  /// Draws the view at this pose. `margin`: pixels left out at the silhouette, at depth jumps and at the frame's
  /// border; fewer on objects so small or thin that little would be left. Throws Error(pose, renderer).
  void draw(const Pose& T_camera_object, int margin);

  /// Where the object lies in the frame, pixels; empty when it is out of view.
  const cv::Rect& region() const { return region_; }
  /// CV_8U, of the region: not 0 where the surface is seen and away from borders.
  const cv::Mat& safe() const { return safe_; }
  /// Is the point that projects to these pixels of the ideal (undistorted) frame, at this depth, seen and away from
  /// borders?
  bool sees(float u, float v, float depth) const {
    const int x = static_cast<int>(u + 0.5F) - region_.x;
    const int y = static_cast<int>(v + 0.5F) - region_.y;
    if (u < 0 || v < 0 || x < 0 || y < 0 || x >= region_.width || y >= region_.height ||
        safe_.at<std::uint8_t>(y, x) == 0) {
      return false;
    }
    const float difference = depth - depth_.at<float>(y, x);
    const float allowed = slope_.at<float>(y, x) + kDepthTolerance * depth;
    return difference < allowed && -difference < allowed;
  }

 private:
  static constexpr float kDepthTolerance = 0.003F;

  void find_region(const Pose& T_camera_object);

  Camera camera_;
  Renderer renderer_;
  Eigen::Vector3d low_, high_;  // bounding box, object frame
  cv::Rect region_;
  cv::Mat depth_;  // CV_32F of the region, metres, 0 where empty
  cv::Mat slope_;  // CV_32F: how much the depth changes to the next pixels
  cv::Mat safe_;
};

}  // namespace holdfast::baking
