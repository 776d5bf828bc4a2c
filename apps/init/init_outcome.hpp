#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/mesh.hpp"
#include "init/point_pairs.hpp"
#include "init/pose_from_points.hpp"
#include "init/refine_on_frame.hpp"

namespace holdfast::app {

/// The pose that `holdfast init` has found by points.
struct InitOutcome {
  cv::Mat frame;  ///< empty: none was given
  std::optional<Mesh> mesh;
  std::vector<PointPair> given;
  std::vector<double> off_surface;  ///< of each, from the mesh, metres; empty without one
  PoseFromPoints from_points;
  std::optional<RefinementOnFrame> refinement;

  bool focal_estimated = false;

  const Pose& pose() const { return refinement ? refinement->T_camera_object : from_points.T_camera_object; }
};

/// For people; with the pose's matrix where `with_pose`, and the files that were written.
std::string text_of(const InitOutcome& outcome, bool with_pose, const std::vector<std::filesystem::path>& written);

/// All of it as a JSON object.
std::string json_of(const InitOutcome& outcome);

}  // namespace holdfast::app
