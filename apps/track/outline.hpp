#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::app {

/// A straight line in the picture, pixels.
struct Line {
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

/// The lines that one would draw a model with: its sharp edges, its borders and its silhouette.
class Outline {
 public:
  /// Frames of `camera`'s size. Throws Error(renderer, model).
  Outline(const Mesh& mesh, const Camera& camera);

  /// The lines at this pose, without those hidden by the model itself or outside the frame. Valid until the next call.
  const std::vector<Line>& lines(const Pose& T_camera_object);

 private:
  struct Edge {
    std::array<std::uint32_t, 2> vertices{};
    std::array<std::int32_t, 2> triangles{-1, -1};
    bool sharp = false;    // always drawn; others only where they are the silhouette
    bool flipped = false;  // the two triangles are wound against each other
  };

  void collect_edges(const Mesh& mesh);
  void render_depth(const Pose& T_camera_object);
  bool is_drawn(const Edge& edge) const;
  bool is_visible(const Eigen::Vector3d& p_camera) const;
  std::uint32_t root_of(std::uint32_t vertex);
  void drop_specks();
  void add_visible_parts(const Eigen::Vector3d& begin_camera, const Eigen::Vector3d& end_camera);

  Camera camera_;
  Renderer renderer_;
  std::vector<Eigen::Vector3f> positions_;  // welded: texture seams are no borders
  std::vector<Eigen::Vector3f> normals_;    // a triangle, object frame, unit length or zero
  std::vector<std::uint32_t> corner_;       // a triangle: one of its vertices
  std::vector<Edge> edges_;

  // Of the last pose:
  Rect roi_;
  std::vector<std::uint8_t> rgba_;
  std::vector<float> depth_;  // of roi_, metres, 0 where empty
  std::vector<Eigen::Vector3d> p_camera_;
  std::vector<bool> front_;  // a triangle: faces the camera
  std::vector<Line> lines_;
  std::vector<std::uint32_t> lines_vertex_;  // a line: a vertex of its edge
  std::vector<std::uint32_t> connected_to_;  // a vertex: another that it hangs together with by lines, or itself
  std::vector<double> connected_length_;     // a vertex that others lead to: pixels of line
};

}  // namespace holdfast::app
