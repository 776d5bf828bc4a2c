#include "base/closed_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/welded_vertices.hpp"

namespace holdfast {
namespace {

/// Disjoint sets of vertices.
class Components {
 public:
  explicit Components(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

bool is_closed_outward(const Mesh& mesh) {
  const std::vector<std::uint32_t> welded = welded_vertices(mesh, false);
  // An edge from a to b, kept as (smaller, larger) with its direction: as many one way as the other when closed.
  struct Edge {
    std::uint32_t a, b;
    int direction;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  Components components(mesh.positions.size());
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = welded[triangle[i]], b = welded[triangle[(i + 1) % 3]];
      if (a == b) continue;
      edges.push_back(a < b ? Edge{a, b, 1} : Edge{b, a, -1});
      components.join(a, b);
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& x, const Edge& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    int balance = 0;
    for (; last < edges.size() && edges[last].a == edges[first].a && edges[last].b == edges[first].b; ++last) {
      balance += edges[last].direction;
    }
    if (balance != 0) return false;
  }
  // Each closed part encloses a positive volume when its fronts look outwards (a cavity's would be negative).
  const Eigen::Vector3d origin = mesh.center().cast<double>();
  std::vector<double> volume(mesh.positions.size(), 0.0);
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
      return mesh.positions[triangle[i]].cast<double>() - origin;
    };
    volume[components.root(welded[triangle[0]])] += corner(0).dot(corner(1).cross(corner(2)));
  }
  const double least = 1e-6 * std::pow(mesh.radius(), 3);
  for (const auto& triangle : mesh.triangles) {
    if (volume[components.root(welded[triangle[0]])] < least) return false;
  }
  return true;
}

}  // namespace holdfast
