#pragma once

#include <memory>
#include <opencv2/core.hpp>

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

  /// The camera picture with the model's outline, at its left; at its right what became of each pixel (used: green,
  /// rejected: shades of red by the test); below, status and figures. BGR8.
  const cv::Mat& overlay_picture(const TrackedFrame& tracked);

  /// The camera picture with the model's outline alone. BGR8, the panel's size.
  const cv::Mat& outline_picture(const TrackedFrame& tracked);

 private:
  void undistort(const cv::Mat& image);
  void draw_outline(const TrackedFrame& tracked, cv::Mat& panel);
  void draw_decisions(const PixelMask& mask, cv::Mat& panel);
  void draw_figures(const TrackedFrame& tracked, cv::Mat& strip);

  Outline outline_;
  double scale_;  // panel pixels a frame pixel
  cv::Size panel_size_;
  cv::Mat map_x_, map_y_;  // empty without lens distortion
  cv::Mat straight_, panel_, grey_, grey_bgr_, classes_, picture_;
};

}  // namespace holdfast::app
