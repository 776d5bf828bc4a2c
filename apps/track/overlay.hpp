#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "track/outline.hpp"
#include "track/tracked_frame.hpp"

namespace holdfast::app {

/// Draws tracked frames for people. Pictures show the frame without lens distortion, which is how the tracker sees it.
class Overlay {
 public:
  /// Throws Error(renderer, model).
  Overlay(const Mesh& mesh, const Camera& camera);

  /// Size of overlay_picture().
  cv::Size overlay_size() const;

  /// Size of window_picture().
  cv::Size window_size() const;

  /// The camera picture with the model's outline, at its left; at its right what became of each pixel (used: green,
  /// rejected: shades of red by the test), or of each line across the contour where that holds the object; below,
  /// status and figures. BGR8.
  const cv::Mat& overlay_picture(const TrackedFrame& tracked);

  /// The camera picture, or what became of each pixel, with the model's outline and axes; below, status with its reason
  /// and `note`. BGR8.
  const cv::Mat& window_picture(const TrackedFrame& tracked, bool decisions, const std::string& note);

  /// The camera picture with the model's outline alone. BGR8, the panel's size.
  const cv::Mat& outline_picture(const TrackedFrame& tracked);

 private:
  void undistort(const cv::Mat& image);
  void draw_outline(const TrackedFrame& tracked, cv::Mat& panel);
  void draw_axes(const Pose& T_camera_object, cv::Mat& panel) const;
  void draw_status(const TrackedFrame& tracked, const std::string& note, cv::Mat& strip) const;
  void draw_decisions(const TrackedFrame& tracked, cv::Mat& panel);
  void draw_contour_dots(const PixelMask& mask, cv::Mat& panel) const;
  void draw_figures(const TrackedFrame& tracked, cv::Mat& strip);

  cv::Point fixed_point(const Eigen::Vector2d& pixel) const;

  Camera camera_;
  Eigen::Vector3d p_object_center_;
  double radius_;
  Outline outline_;
  double scale_;  // panel pixels a frame pixel
  cv::Size panel_size_;
  cv::Mat map_x_, map_y_;  // empty without lens distortion
  cv::Mat straight_, panel_, grey_, grey_bgr_, classes_, picture_;
};

}  // namespace holdfast::app
