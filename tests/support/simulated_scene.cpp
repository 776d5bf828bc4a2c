#include "support/simulated_scene.hpp"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "simulation/light_encoding.hpp"

namespace holdfast::test {

using namespace simulation;

double linear(double grey) { return linear_from_encoded(grey / 255.0); }

std::filesystem::path plain_background(const TemporaryFolder& folder, int grey) {
  const std::filesystem::path path = folder / "background.png";
  cv::imwrite(path.string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(grey)));
  return path;
}

SequenceOptions still_options(const TemporaryFolder& folder, const Camera& camera, const Pose& pose) {
  SequenceOptions options;
  options.camera = camera;
  options.frames = 1;
  options.samples = 8;
  options.motion.T_camera_object = {pose};
  options.lighting = LightingOptions::flat();
  options.background.file = plain_background(folder, 0);
  return options;
}

std::vector<cv::Point2d> project(const std::vector<Eigen::Vector3d>& points, const Pose& pose, const Camera& camera) {
  std::vector<cv::Point3d> p_camera;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d moved = pose * p;
    p_camera.emplace_back(moved.x(), moved.y(), moved.z());
  }
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(p_camera, cv::Vec3d(), cv::Vec3d(), matrix, distortion, pixels);
  return pixels;
}

std::vector<Eigen::Vector3d> corners_of(const Mesh& mesh) {
  const auto corners = bounding_corners(mesh);
  return {corners.begin(), corners.end()};
}

}  // namespace holdfast::test
