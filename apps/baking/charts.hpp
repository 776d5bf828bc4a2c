#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "baking/mesh_topology.hpp"
#include "holdfast/mesh.hpp"

namespace holdfast::baking {

/// Triangles that can be laid flat side by side by looking along `axis`.
struct Chart {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit length, towards the viewer
  std::vector<std::uint32_t> triangles;
};

/// Divides a mesh into charts: every triangle with an area belongs to one, is seen from its front along the chart's
/// axis, and covers no other triangle of the chart. Triangles are within `cone` (radians) of the axis, but for those of
/// charts smaller than `least_extent` (metres), which join a neighbour where they can.
std::vector<Chart> make_charts(const Mesh& mesh, const MeshTopology& topology, double cone, double least_extent);

/// Two directions across a chart's axis: the picture that one sees looking against it.
struct ChartPlane {
  Eigen::Vector3d right;
  Eigen::Vector3d down;
  explicit ChartPlane(const Eigen::Vector3d& axis);
  Eigen::Vector2d project(const Eigen::Vector3f& p_object) const {
    return {right.dot(p_object.cast<double>()), down.dot(p_object.cast<double>())};
  }
};

}  // namespace holdfast::baking
