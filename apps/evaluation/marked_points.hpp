#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/estimated_poses.hpp"
#include "evaluation/statistics.hpp"
#include "holdfast/camera.hpp"

/// Poses against points that somebody marked in the frames: the check for recordings without true poses.
namespace holdfast::evaluation {

/// A point of the model and where it was seen.
struct MarkedPoint {
  int frame = 0;
  Eigen::Vector3d p_object = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();     ///< of the recorded frame, lens distortion included
};

/// Reads lines frame,x,y,z,u,v (metres, pixels); '#' starts a comment. Throws Error(file) naming the line that is
/// wrong.
std::vector<MarkedPoint> load_marked_points(const std::filesystem::path& file);

/// Where a pose puts a marked point.
struct MarkDistance {
  MarkedPoint mark;
  bool held = false;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< projected minus marked, pixels; infinite behind the camera
};

/// One a mark, in the order of the marks. Throws Error(file) when a marked frame has no pose.
std::vector<MarkDistance> mark_distances(const std::vector<MarkedPoint>& marks, const EstimatedPoses& poses,
                                         const Camera& camera);

/// Distances of all marks, pixels; infinite where the object was not held.
Spread mark_spread(const std::vector<MarkDistance>& distances);

/// A line a frame with the distance of each of its marks, then median and largest of all. Pixels.
std::string mark_table(const std::vector<MarkDistance>& distances);

}  // namespace holdfast::evaluation
