#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "edges/visible_edges.hpp"
#include "holdfast/mesh.hpp"

/// Meshes whose edges are known, and lines across them.
namespace holdfast::test {

/// Adds a quadrangle of `parts` x `parts` squares of two triangles each, whose front is at the side of u x v.
inline void add_face(Mesh& mesh, const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                     int parts = 1) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto row = static_cast<std::uint32_t>(parts + 1);
  for (int j = 0; j <= parts; ++j) {
    for (int i = 0; i <= parts; ++i) {
      // Exact where faces meet, so that vertices are welded.
      const auto along = [&](int n) { return n == parts ? 1.0F : static_cast<float>(n) / static_cast<float>(parts); };
      mesh.positions.push_back(corner + along(i) * u + along(j) * v);
    }
  }
  for (std::uint32_t j = 0; j + 1 < row; ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = first + j * row + i, b = a + 1, c = a + row, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
}

/// A block about the origin; its faces have vertices of their own.
inline Mesh block(const Eigen::Vector3f& size, int parts = 1) {
  Mesh mesh;
  const Eigen::Vector3f half = 0.5F * size;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      Eigen::Vector3f corner = -half, u = Eigen::Vector3f::Zero(), v = Eigen::Vector3f::Zero();
      corner(axis) = side * half(axis);
      u(side > 0 ? next : last) = size(side > 0 ? next : last);
      v(side > 0 ? last : next) = size(side > 0 ? last : next);
      add_face(mesh, corner, u, v, parts);
    }
  }
  return mesh;
}

/// A closed can about the z axis.
inline Mesh can(float radius, float height, int facets) {
  Mesh mesh;
  const auto count = static_cast<std::uint32_t>(facets);
  for (const float z : {-0.5F * height, 0.5F * height}) {
    for (int i = 0; i < facets; ++i) {
      const double angle = 2 * std::numbers::pi * i / facets;
      mesh.positions.emplace_back(radius * static_cast<float>(std::cos(angle)),
                                  radius * static_cast<float>(std::sin(angle)), z);
    }
  }
  mesh.positions.emplace_back(0.0F, 0.0F, -0.5F * height);
  mesh.positions.emplace_back(0.0F, 0.0F, 0.5F * height);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, next, next + count});
    mesh.triangles.push_back({i, next + count, i + count});
    mesh.triangles.push_back({next, i, 2 * count});
    mesh.triangles.push_back({i + count, next + count, 2 * count + 1});
  }
  return mesh;
}

/// A sphere of many triangles about the origin.
inline Mesh ball(float radius) {
  constexpr int kRings = 30, kColumns = 50;
  Mesh mesh;
  for (int j = 0; j <= kRings; ++j) {
    const double polar = std::numbers::pi * j / kRings;
    for (int i = 0; i < kColumns; ++i) {
      const double angle = 2 * std::numbers::pi * i / kColumns;
      const double out = j == 0 || j == kRings ? 0 : std::sin(polar);  // poles are one point each
      mesh.positions.emplace_back(radius * static_cast<float>(out * std::cos(angle)),
                                  radius * static_cast<float>(out * std::sin(angle)),
                                  radius * static_cast<float>(std::cos(polar)));
    }
  }
  const auto at = [](int row, int column) { return static_cast<std::uint32_t>(row * kColumns + column % kColumns); };
  for (int j = 0; j < kRings; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      mesh.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
    }
  }
  return mesh;
}

/// A line at every sample, hidden or not.
inline std::vector<VisibleEdge> lines_at(const std::vector<EdgeSample>& samples, const Pose& T_camera_object,
                                         const Camera& camera) {
  std::vector<VisibleEdge> lines;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    VisibleEdge line;
    line.sample = static_cast<int>(i);
    line.p_camera = T_camera_object * samples[i].p_object.cast<double>();
    line.pixel = camera.project(line.p_camera);
    const Eigen::Vector3d beside = T_camera_object * (samples[i].p_object + 1e-3F * samples[i].along).cast<double>();
    const Eigen::Vector2d along = (camera.project(beside) - line.pixel).normalized();
    line.normal = {-along.y(), along.x()};
    lines.push_back(line);
  }
  return lines;
}

}  // namespace holdfast::test
