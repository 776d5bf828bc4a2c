#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "init/check_picture.hpp"
#include "init/point_pairs.hpp"

namespace holdfast::app {

/// The vertices that a user is asked to find: all of a simple model, a few spread over a dense one.
std::vector<Eigen::Vector3d> vertices_to_click(const Mesh& mesh);

/// What happens while a user clicks the model's vertices in a frame, without the window: a vertex after the other is
/// asked for; each is clicked or skipped.
class ClickSession {
 public:
  /// `camera`: for the preview of the pose; nothing when it is unknown.
  ClickSession(const cv::Mat& frame, const Mesh& mesh, const std::optional<Camera>& camera);

  /// Place in picture(), where the current vertex is seen.
  void click(const Eigen::Vector2d& place);
  void skip();
  /// Back to the vertex before, forgetting its click.
  void back();
  /// Turns the drawing of the model, radians.
  void turn_model(double yaw, double pitch);

  bool all_asked() const { return current_ >= vertices_.size(); }
  std::vector<PointPair> pairs() const;
  /// The frame with what was clicked, the pose as far as it is known, and the model with the vertex asked for.
  cv::Mat picture() const;

 private:
  void draw_model(cv::Mat& inset) const;
  void draw_preview(EnlargedFrame& enlarged) const;

  cv::Mat frame_;
  const Mesh& mesh_;
  std::optional<Camera> camera_;
  EnlargedFrame enlarged_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::optional<Eigen::Vector2d>> clicks_;  // pixels of the frame, one a vertex
  std::size_t current_ = 0;
  double yaw_ = 0.6;
  double pitch_ = 0.5;
};

/// Throws Error(invalid_argument) when no window can be opened. Before any use of a device: it forks.
void require_display();

/// Runs a session in a window until the user is done. Throws Error(invalid_argument) when the user gives up.
std::vector<PointPair> click_points(const cv::Mat& frame, const Mesh& mesh, const std::optional<Camera>& camera);

}  // namespace holdfast::app
