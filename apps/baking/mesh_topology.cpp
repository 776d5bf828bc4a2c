#include "baking/mesh_topology.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

namespace holdfast::baking {
namespace {

/// For each vertex the first one at its place.
std::vector<std::uint32_t> welded_vertices(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = static_cast<std::uint32_t>(i);
  }
  const auto key = [&mesh](std::uint32_t i) {
    const Eigen::Vector3f& p = mesh.positions[i];
    return std::make_tuple(p.x(), p.y(), p.z());
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::make_pair(key(a), a) < std::make_pair(key(b), b); });
  std::vector<std::uint32_t> welded(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    welded[order[i]] = same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

struct HalfEdge {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  std::uint8_t edge = 0;
  bool rising = false;  // runs from low to high
};

}  // namespace

MeshTopology topology_of(const Mesh& mesh) {
  mesh.validate();
  MeshTopology topology;
  const std::size_t count = mesh.triangles.size();
  topology.neighbors.assign(count, {-1, -1, -1});
  topology.normals.resize(count);
  topology.areas.resize(count);
  const std::vector<std::uint32_t> welded = welded_vertices(mesh);

  const Eigen::Vector3d center = mesh.center();
  double volume = 0;
  std::vector<HalfEdge> edges;
  edges.reserve(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.positions[mesh.triangles[t][k]].cast<double>() - center;
    }
    const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
    topology.areas[t] = 0.5 * cross.norm();
    topology.normals[t] = topology.areas[t] > 0 ? Eigen::Vector3d(cross.normalized()) : Eigen::Vector3d::Zero();
    volume += p[0].dot(cross);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = welded[mesh.triangles[t][k]];
      const std::uint32_t b = welded[mesh.triangles[t][(k + 1) % 3]];
      if (a != b) {
        edges.push_back(
            {std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(t), static_cast<std::uint8_t>(k), a < b});
      }
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle, a.edge) < std::tie(b.low, b.high, b.triangle, b.edge);
  });

  topology.closed = true;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) {
      ++end;
    }
    const bool pair = end - i == 2;
    if (pair) {
      topology.neighbors[edges[i].triangle][edges[i].edge] = static_cast<std::int32_t>(edges[i + 1].triangle);
      topology.neighbors[edges[i + 1].triangle][edges[i + 1].edge] = static_cast<std::int32_t>(edges[i].triangle);
    }
    topology.closed = topology.closed && pair && edges[i].rising != edges[i + 1].rising;
    i = end;
  }
  topology.inside_out = topology.closed && volume < 0;
  return topology;
}

}  // namespace holdfast::baking
