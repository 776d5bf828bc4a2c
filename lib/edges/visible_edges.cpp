#include "edges/visible_edges.hpp"

#include <algorithm>
#include <cmath>

#include "device/shared.h"

namespace holdfast {
namespace {

/// Pixels beside an edge at which its faces are looked for.
constexpr double kBeside = 1.5;
/// Depth where nothing is drawn, metres.
constexpr double kNothing = 1e9;
/// Shortest projection of a sample's direction, over its length, that still has a normal.
constexpr double kLeastSlant = 0.05;
/// Pixels between samples of a chain, at least: nearer ones say the same.
constexpr double kLeastPixels = 1.5;
/// Times the tolerance that what is seen beside an edge lies behind it where the object ends there.
constexpr double kFar = 3;

}  // namespace

void visible_edges(const std::vector<EdgeSample>& samples, const Pose& T_camera_object, const Camera& camera,
                   const DrawnDepth& drawn, double tolerance, std::size_t most, std::vector<VisibleEdge>& visible) {
  visible.clear();
  const Eigen::Matrix3d R = T_camera_object.linear();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const EdgeSample& sample = samples[i];
    VisibleEdge edge;
    edge.p_camera = T_camera_object * sample.p_object.cast<double>();
    const double z = edge.p_camera.z();
    if (z < 1e-6) continue;
    const auto faces_camera = [&](const Eigen::Vector3f& normal) {
      return (R * normal.cast<double>()).dot(edge.p_camera) < 0;
    };
    edge.faces = (faces_camera(sample.first) ? 1 : 0) | (faces_camera(sample.second) ? 2 : 0);
    if (edge.faces == 0) continue;
    edge.pixel = camera.project(edge.p_camera);
    if (!(edge.pixel.x() > 1 && edge.pixel.y() > 1 && edge.pixel.x() < camera.width - 2 &&
          edge.pixel.y() < camera.height - 2)) {
      continue;
    }
    if (!visible.empty() && samples[static_cast<std::size_t>(visible.back().sample)].chain == sample.chain &&
        (edge.pixel - visible.back().pixel).squaredNorm() < kLeastPixels * kLeastPixels) {
      continue;
    }
    const Eigen::Vector3d t = R * sample.along.cast<double>();
    const Eigen::Vector2d direction(camera.fx * (t.x() - t.z() * edge.p_camera.x() / z),
                                    camera.fy * (t.y() - t.z() * edge.p_camera.y() / z));
    if (direction.norm() < kLeastSlant * camera.fx) continue;
    edge.normal = Eigen::Vector2d(-direction.y(), direction.x()).normalized();
    const auto beside = [&](double side) {  // pixels along the normal
      const Eigen::Vector2d at = edge.pixel + side * edge.normal;
      const float depth = drawn.at(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
      return depth < 1.0F ? drawn.range.metric(static_cast<double>(depth)) : kNothing;
    };
    const double left = beside(kBeside), right = beside(-kBeside);
    if (std::max(left, right) < z - tolerance) continue;
    // Where a smooth surface turns away its outline lies beside a border on it, and looks like it.
    const bool smooth = sample.first.dot(sample.second) > kCreaseCosine;
    if (smooth && !(beside(HF_EDGE_REACH + 1) < kNothing && beside(-HF_EDGE_REACH - 1) < kNothing)) continue;
    edge.outward = (left > z + kFar * tolerance ? 1 : 0) - (right > z + kFar * tolerance ? 1 : 0);
    edge.sample = static_cast<int>(i);
    visible.push_back(edge);
  }
  if (visible.size() <= most) return;
  const double step = static_cast<double>(visible.size()) / static_cast<double>(most);
  for (std::size_t i = 0; i < most; ++i) {
    visible[i] = visible[static_cast<std::size_t>((static_cast<double>(i) + 0.5) * step)];
  }
  visible.resize(most);
}

}  // namespace holdfast
