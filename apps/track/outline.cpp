#include "track/outline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace holdfast::app {
namespace {

constexpr float kSharpCosine = 0.866F;    // faces meeting at more than 30 degrees
constexpr double kWeldTolerance = 1e-6;   // of the model's radius: vertices this near are one
constexpr double kNearest = 1e-6;         // metres: what is nearer has no place in the picture
constexpr double kSpeckLength = 16;       // pixels: shorter lines, all that hang together counted, are left out
constexpr double kSampleStep = 2;         // pixels between visibility tests along a line
constexpr double kDepthTolerance = 0.01;  // relative

/// Pixels that the model's bounding sphere can touch, inside the frame.
Rect region_of(const Eigen::Vector3d& center_camera, double radius, const Camera& camera) {
  const double z = center_camera.z() - radius;
  if (z <= 0) {
    return {0, 0, camera.width, camera.height};
  }
  // The nearest point of the sphere bounds how far out its picture reaches, the farthest how far in.
  const auto project_axis = [z, radius](double from, double f, double c, bool lower) {
    const double edge = lower ? from - radius : from + radius;
    const bool nearer_is_wider = lower ? edge < 0 : edge > 0;
    return f * edge / (nearer_is_wider ? z : z + 2 * radius) + c;
  };
  const double left = project_axis(center_camera.x(), camera.fx, camera.cx, true);
  const double right = project_axis(center_camera.x(), camera.fx, camera.cx, false);
  const double top = project_axis(center_camera.y(), camera.fy, camera.cy, true);
  const double bottom = project_axis(center_camera.y(), camera.fy, camera.cy, false);
  const auto clipped = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  const int x0 = clipped(std::floor(left) - 2, camera.width);
  const int y0 = clipped(std::floor(top) - 2, camera.height);
  const int x1 = clipped(std::ceil(right) + 3, camera.width);
  const int y1 = clipped(std::ceil(bottom) + 3, camera.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace

Outline::Outline(const Mesh& mesh, const Camera& camera)
    : camera_(camera), renderer_(mesh, camera.width, camera.height) {
  collect_edges(mesh);
  p_camera_.resize(positions_.size());
  connected_to_.resize(positions_.size());
  connected_length_.resize(positions_.size());
  front_.resize(normals_.size());
}

void Outline::collect_edges(const Mesh& mesh) {
  const double cell = mesh.radius() * kWeldTolerance;
  std::map<std::array<std::int64_t, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> welded;
  welded.reserve(mesh.positions.size());
  for (const Eigen::Vector3f& position : mesh.positions) {
    const std::array<std::int64_t, 3> key = {std::llround(position.x() / cell), std::llround(position.y() / cell),
                                             std::llround(position.z() / cell)};
    const auto [place, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(positions_.size()));
    if (is_new) {
      positions_.push_back(position);
    }
    welded.push_back(place->second);
  }

  // For each edge, by its vertices in ascending order: which edge, and whether its first triangle runs upwards.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::size_t, bool>> edge_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<std::uint32_t, 3> corners = {welded[mesh.triangles[t][0]], welded[mesh.triangles[t][1]],
                                                  welded[mesh.triangles[t][2]]};
    const Eigen::Vector3f a = positions_[corners[0]];
    normals_.push_back((positions_[corners[1]] - a).cross(positions_[corners[2]] - a).normalized());
    corner_.push_back(corners[0]);
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = corners[i];
      const std::uint32_t to = corners[(i + 1) % 3];
      const bool upwards = from < to;
      const auto [place, is_new] = edge_of.try_emplace(std::minmax(from, to), edges_.size(), upwards);
      if (is_new) {
        edges_.push_back({{from, to}, {static_cast<std::int32_t>(t), -1}, true, false});
        continue;
      }
      Edge& edge = edges_[place->second.first];
      if (edge.triangles[1] >= 0) {
        edge.sharp = true;  // three surfaces meet
        continue;
      }
      edge.triangles[1] = static_cast<std::int32_t>(t);
      edge.flipped = place->second.second == upwards;
      const float cosine = normals_[edge.triangles[0]].dot(normals_[t]);
      edge.sharp = (edge.flipped ? -cosine : cosine) < kSharpCosine;
    }
  }
}

const std::vector<Line>& Outline::lines(const Pose& T_camera_object) {
  lines_.clear();
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    p_camera_[i] = T_camera_object * positions_[i].cast<double>();
  }
  render_depth(T_camera_object);
  if (roi_.empty()) {
    return lines_;
  }
  const Eigen::Vector3f camera_object = T_camera_object.inverse().translation().cast<float>();
  for (std::size_t t = 0; t < normals_.size(); ++t) {
    front_[t] = normals_[t].dot(camera_object - positions_[corner_[t]]) > 0;
  }
  lines_vertex_.clear();
  std::iota(connected_to_.begin(), connected_to_.end(), 0U);
  for (const Edge& edge : edges_) {
    if (is_drawn(edge)) {
      add_visible_parts(p_camera_[edge.vertices[0]], p_camera_[edge.vertices[1]]);
      if (lines_.size() > lines_vertex_.size()) {
        connected_to_[root_of(edge.vertices[0])] = root_of(edge.vertices[1]);
        lines_vertex_.resize(lines_.size(), edge.vertices[0]);
      }
    }
  }
  drop_specks();
  return lines_;
}

std::uint32_t Outline::root_of(std::uint32_t vertex) {
  while (connected_to_[vertex] != vertex) {
    connected_to_[vertex] = connected_to_[connected_to_[vertex]];
    vertex = connected_to_[vertex];
  }
  return vertex;
}

/// Scanned and simplified meshes have slivers whose normals mean nothing: they leave short lines that hang together
/// with no others.
void Outline::drop_specks() {
  std::fill(connected_length_.begin(), connected_length_.end(), 0.0);
  double longest = 0;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    double& length = connected_length_[root_of(lines_vertex_[i])];
    length += (lines_[i].end - lines_[i].begin).norm();
    longest = std::max(longest, length);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (connected_length_[root_of(lines_vertex_[i])] >= std::min(kSpeckLength, longest)) {
      lines_[kept++] = lines_[i];
    }
  }
  lines_.resize(kept);
}

void Outline::render_depth(const Pose& T_camera_object) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : p_camera_) {
    box.extend(p);
  }
  roi_ = region_of(box.center(), box.diagonal().norm() / 2, camera_);
  if (roi_.empty()) {
    return;
  }
  const std::size_t pixels = static_cast<std::size_t>(roi_.width) * static_cast<std::size_t>(roi_.height);
  rgba_.resize(4 * pixels);
  depth_.resize(pixels);
  const DepthRange range =
      renderer_.render(T_camera_object, camera_, roi_, RenderTarget{rgba_.data(), depth_.data(), roi_.width});
  const double near = range.near_plane;
  const double far = range.far_plane;
  for (float& depth : depth_) {
    depth = depth >= 1.0F ? 0.0F : static_cast<float>(near * far / (far - depth * (far - near)));
  }
}

bool Outline::is_drawn(const Edge& edge) const {
  if (edge.sharp) {
    return true;
  }
  const bool one = front_[edge.triangles[0]];
  const bool other = front_[edge.triangles[1]];
  return (one != other) != edge.flipped;
}

/// A point of an edge is visible when some pixel around it shows nothing nearer.
bool Outline::is_visible(const Eigen::Vector3d& p_camera) const {
  if (p_camera.z() < kNearest) {
    return false;
  }
  const Eigen::Vector2d pixel = camera_.project(p_camera);
  if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < camera_.width - 0.5 && pixel.y() < camera_.height - 0.5)) {
    return false;
  }
  const int u = static_cast<int>(std::lround(pixel.x())) - roi_.x;
  const int v = static_cast<int>(std::lround(pixel.y())) - roi_.y;
  for (int y = std::max(v - 1, 0); y <= std::min(v + 1, roi_.height - 1); ++y) {
    for (int x = std::max(u - 1, 0); x <= std::min(u + 1, roi_.width - 1); ++x) {
      const double depth = depth_[static_cast<std::size_t>(y) * roi_.width + x];
      if (depth == 0 || p_camera.z() <= depth * (1 + kDepthTolerance)) {
        return true;
      }
    }
  }
  return false;
}

void Outline::add_visible_parts(const Eigen::Vector3d& begin_camera, const Eigen::Vector3d& end_camera) {
  if (begin_camera.z() < kNearest || end_camera.z() < kNearest) {
    return;
  }
  const double length = (camera_.project(end_camera) - camera_.project(begin_camera)).norm();
  const int parts = static_cast<int>(std::clamp(length / kSampleStep, 1.0, 2000.0));
  const auto at = [&](double share) -> Eigen::Vector3d { return begin_camera + share * (end_camera - begin_camera); };
  int first_visible = -1;
  for (int i = 0; i <= parts; ++i) {
    const bool visible = i < parts && is_visible(at((i + 0.5) / parts));
    if (visible && first_visible < 0) {
      first_visible = i;
    } else if (!visible && first_visible >= 0) {
      lines_.push_back({camera_.project(at(static_cast<double>(first_visible) / parts)),
                        camera_.project(at(static_cast<double>(i) / parts))});
      first_visible = -1;
    }
  }
}

}  // namespace holdfast::app
