#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "init/point_pairs.hpp"
#include "track/outline.hpp"

namespace holdfast::app {

/// A frame enlarged, so that one sees where things are to a fraction of a pixel.
class EnlargedFrame {
 public:
  explicit EnlargedFrame(const cv::Mat& frame);

  cv::Mat& picture() { return picture_; }
  int factor() const { return factor_; }
  /// Place in the picture of a pixel of the frame, and back. Pixel centres are integers in both.
  Eigen::Vector2d to_picture(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d to_frame(const Eigen::Vector2d& place) const;

  /// Lines of the ideal pinhole image, bent by the camera's lens.
  void draw_lines(const std::vector<Line>& lines, const Camera& camera, const cv::Scalar& color);
  void draw_cross(const Eigen::Vector2d& pixel, const cv::Scalar& color);
  void draw_circle(const Eigen::Vector2d& pixel, const cv::Scalar& color);
  void draw_text(const std::string& text, const Eigen::Vector2d& place, const cv::Scalar& color);

 private:
  int factor_;
  cv::Mat picture_;
};

/// The picture to check a pose by eye: the model's outline (green), the points as marked (red crosses) and as the pose
/// puts them (yellow circles), numbered in their order.
cv::Mat check_picture(const cv::Mat& frame, const Camera& camera, const Pose& T_camera_object,
                      const std::vector<Line>& outline, const std::vector<PointPair>& pairs);

/// Writes an image file, format by its extension; throws Error(output).
void save_picture(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace holdfast::app
