#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::app {

/// A point of the model and where it was seen in a frame.
struct PointPair {
  Eigen::Vector3d p_object = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();     ///< of the recorded frame, lens distortion included
  std::string name;                                    ///< for messages: "line 3"
};

/// Reads a CSV file of lines x,y,z,u,v; '#' starts a comment, a first line of words is a heading. `scale` turns the
/// file's unit into metres. Throws Error(file), and Error(pose) naming the line that is wrong.
std::vector<PointPair> load_point_pairs(const std::filesystem::path& path, double scale);

/// Writes such a file, in metres; throws Error(output).
void save_point_pairs(const std::filesystem::path& path, const std::vector<PointPair>& pairs);

}  // namespace holdfast::app
