#pragma once

#include <vector>

#include "edges/model_edges.hpp"
#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "image/depth_view.hpp"

namespace holdfast {

/// A sample as it is seen.
struct VisibleEdge {
  int sample = 0;
  Eigen::Vector3d p_camera = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit, to the left of the edge as its sample runs
  int faces = 0;                                     ///< bits of the faces towards the camera: 1, 2
  int outward = 0;  ///< 1: the object ends on the normal's side, -1: on the other, 0: on neither
};

/// Object radii that a sample may lie behind what is drawn.
inline constexpr double kBehind = 0.03;

/// The samples that nothing of the object hides at the pose that `drawn` was drawn at, at most `most`, evenly taken.
/// `tolerance`: metres that a sample may lie behind what is drawn.
void visible_edges(const std::vector<EdgeSample>& samples, const Pose& T_camera_object, const Camera& camera,
                   const DrawnDepth& drawn, double tolerance, std::size_t most, std::vector<VisibleEdge>& visible);

}  // namespace holdfast
