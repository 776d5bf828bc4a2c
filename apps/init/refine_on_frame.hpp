#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/device.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

struct RefinementOnFrame {
  Pose T_camera_object = Pose::Identity();  ///< refined when accepted, else the pose it started from
  bool accepted = false;
  std::string reason;      ///< why it was not accepted
  double correlation = 0;  ///< of rendered view and frame, [-1, 1]
  double moved = 0;        ///< how far the refinement took the points, pixels (root mean square)
};

/// Refines a pose by the object's look in a frame (BGR8 of the camera's size). It is not accepted when the tracker
/// calls the object lost there, or when the result disagrees with the point pairs.
RefinementOnFrame refine_on_frame(const Mesh& mesh, const Camera& camera, const Device& device, const cv::Mat& frame,
                                  const std::vector<PointPair>& pairs, const Pose& T_camera_object);

}  // namespace holdfast::app
