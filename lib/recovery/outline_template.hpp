#pragma once

#include <vector>

#include "edges/model_edges.hpp"
#include "image/depth_view.hpp"

namespace holdfast {

/// A point of an outline: pixels from the projection of the object's centre, and the direction of its normal, radians.
struct OutlinePoint {
  float x = 0, y = 0;
  float normal = 0;      ///< of a contour out of the object
  bool contour = false;  ///< else an edge within it
  Eigen::Vector3f p_camera = Eigen::Vector3f::Zero();
};

/// Points of the contour and of the model's edges in a view, at most `most`, evenly taken; `p_center`: the object's
/// centre in the camera's frame.
std::vector<OutlinePoint> outline_points(const DepthView& view, const std::vector<EdgeSample>& samples,
                                         const Camera& camera, const Eigen::Vector3d& p_center, double radius,
                                         std::size_t most);

}  // namespace holdfast
