#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "simulation/sequence.hpp"
#include "support/files.hpp"

/// What the simulator's own suites share.
namespace holdfast::test {

inline const Camera kSceneCamera = {320, 240, 400, 380, 163.2, 117.4, {}};

/// The light of a grey level, 0 to 255.
double linear(double grey);

/// A still picture of one grey level to put behind things.
std::filesystem::path plain_background(const TemporaryFolder& folder, int grey);

/// One sharp frame of evenly lit surfaces before black.
simulation::SequenceOptions still_options(const TemporaryFolder& folder, const Camera& camera, const Pose& pose);

/// OpenCV's camera model: independent of the simulator's.
std::vector<cv::Point2d> project(const std::vector<Eigen::Vector3d>& points, const Pose& pose, const Camera& camera);

std::vector<Eigen::Vector3d> corners_of(const Mesh& mesh);

}  // namespace holdfast::test
