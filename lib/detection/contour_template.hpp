#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::detection {

/// Directions of gradients, without their sign.
inline constexpr int kDirections = 8;

/// A place of the contour or of a sharp edge, and the direction of the gradient that is expected there.
struct ContourPoint {
  std::int16_t x = 0, y = 0;  ///< pixels of the camera that it is drawn for
  std::uint8_t direction = 0;
};

/// What edges a view of a mesh without any look shows: contour, jumps of depth and sharp edges.
class ContourDrawer {
 public:
  /// Throws Error(renderer, model).
  ContourDrawer(const Mesh& mesh, const Camera& camera);

  /// At most `most` points, evenly chosen; none where the object is out of the picture.
  std::vector<ContourPoint> draw(const Pose& T_camera_object, std::size_t most);

 private:
  Camera camera_;
  Renderer renderer_;
  cv::Mat window_;
};

/// Gradients of a picture, strongest channel: strength where a line of them is strongest (0 elsewhere) and direction.
struct EdgePicture {
  cv::Mat strength;   ///< CV_32F
  cv::Mat direction;  ///< CV_8U, below kDirections
};
EdgePicture edges_of(const cv::Mat& channels);

}  // namespace holdfast::detection
