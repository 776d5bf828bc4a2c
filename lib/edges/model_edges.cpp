#include "edges/model_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "base/welded_vertices.hpp"

namespace holdfast {
namespace {

/// Cosine of the turn from an edge to the next within a chain: 40 degrees.
constexpr float kStraightCosine = 0.766F;
/// Shortest chain, object radii: shorter ones are relief.
constexpr double kShortest = 0.15;
/// Least height of a triangle over its longest side, object radii, that tells which way it faces.
constexpr float kLeastHeight = 1e-5F;
/// Object radii between samples, at least.
constexpr double kLeastSpacing = 0.01;

using Vertex = std::uint32_t;

struct Edge {
  Vertex a = 0, b = 0;
  Eigen::Vector3f first = Eigen::Vector3f::Zero(), second = Eigen::Vector3f::Zero();
  bool used = false;
};

std::vector<Edge> sharp_edges(const Mesh& mesh) {
  const std::vector<Vertex> welded = welded_vertices(mesh, false);
  struct Sides {
    std::vector<std::size_t> triangles;
    Vertex from = 0;  ///< of the first triangle's direction
  };
  std::map<std::pair<Vertex, Vertex>, Sides> sides;
  std::vector<Eigen::Vector3f> normals(mesh.triangles.size(), Eigen::Vector3f::Zero());
  std::vector<std::pair<std::size_t, std::pair<Vertex, Vertex>>> slivers;  // with their longest side
  const float least_height = kLeastHeight * static_cast<float>(mesh.radius());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    const std::array<Vertex, 3> corners{welded[triangle[0]], welded[triangle[1]], welded[triangle[2]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    float longest = 0;
    std::pair<Vertex, Vertex> longest_side;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vertex a = corners[i], b = corners[(i + 1) % 3];
      Sides& there = sides[std::minmax(a, b)];
      if (there.triangles.empty()) there.from = a;
      there.triangles.push_back(t);
      const float length = (mesh.positions[b] - mesh.positions[a]).norm();
      if (length > longest) {
        longest = length;
        longest_side = std::minmax(a, b);
      }
    }
    const auto side = [&](std::size_t i) -> Eigen::Vector3f {
      return mesh.positions[corners[i]] - mesh.positions[corners[0]];
    };
    const Eigen::Vector3f cross = side(1).cross(side(2));
    if (cross.norm() > least_height * longest) {
      normals[t] = cross.normalized();
    } else {
      slivers.emplace_back(t, longest_side);
    }
  }
  // A sliver faces where its neighbour beyond its longest side does, which may be one itself.
  for (std::size_t left = slivers.size() + 1; slivers.size() < left;) {
    left = slivers.size();
    std::erase_if(slivers, [&](const auto& sliver) {
      for (const std::size_t t : sides[sliver.second].triangles) {
        if (!normals[t].isZero()) normals[sliver.first] = normals[t];
      }
      return !normals[sliver.first].isZero();
    });
  }
  const bool textured = mesh.has_appearance();
  std::vector<Edge> edges;
  for (const auto& [ends, there] : sides) {
    const std::size_t first = there.triangles[0], second = there.triangles.back();
    if (normals[first].isZero() || normals[second].isZero()) continue;
    const bool border = there.triangles.size() == 1;
    // Borders of print are texture's to compare.
    const bool materials = !textured && !mesh.triangle_materials.empty() &&
                           mesh.triangle_materials[first] != mesh.triangle_materials[second];
    if (!border && !materials && normals[first].dot(normals[second]) > kCreaseCosine) continue;
    const Vertex other = there.from == ends.first ? ends.second : ends.first;
    edges.push_back({there.from, other, normals[first], border ? Eigen::Vector3f::Zero() : normals[second], false});
  }
  return edges;
}

/// Edges that go straight on from each other, turned so that each begins where the one before ends.
class Chains {
 public:
  Chains(const Mesh& mesh, std::vector<Edge> edges) : mesh_(mesh), edges_(std::move(edges)) {
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      at_[edges_[i].a].push_back(i);
      at_[edges_[i].b].push_back(i);
    }
  }

  std::vector<std::vector<Edge>> all() {
    std::vector<std::vector<Edge>> chains;
    for (Edge& edge : edges_) {
      if (edge.used) continue;
      edge.used = true;
      std::vector<Edge> chain{edge};
      while (follow(chain)) {
      }
      reverse(chain);
      while (follow(chain)) {
      }
      reverse(chain);
      chains.push_back(std::move(chain));
    }
    return chains;
  }

  Eigen::Vector3f vector(const Edge& edge) const { return mesh_.positions[edge.b] - mesh_.positions[edge.a]; }

 private:
  static void turn(Edge& edge) {
    std::swap(edge.a, edge.b);
    std::swap(edge.first, edge.second);
  }
  static void reverse(std::vector<Edge>& chain) {
    std::reverse(chain.begin(), chain.end());
    for (Edge& edge : chain) turn(edge);
  }

  bool follow(std::vector<Edge>& chain) {
    const Vertex end = chain.back().b;
    const Eigen::Vector3f direction = vector(chain.back()).normalized();
    std::size_t best = edges_.size();
    float straightest = kStraightCosine;
    for (const std::size_t i : at_[end]) {
      if (edges_[i].used) continue;
      const Eigen::Vector3f next = vector(edges_[i]).normalized() * (edges_[i].a == end ? 1.0F : -1.0F);
      if (next.dot(direction) > straightest) {
        straightest = next.dot(direction);
        best = i;
      }
    }
    if (best == edges_.size()) return false;
    edges_[best].used = true;
    chain.push_back(edges_[best]);
    if (chain.back().a != end) turn(chain.back());
    return true;
  }

  const Mesh& mesh_;
  std::vector<Edge> edges_;
  std::map<Vertex, std::vector<std::size_t>> at_;
};

}  // namespace

std::vector<EdgeSample> model_edges(const Mesh& mesh, std::size_t most) {
  Chains chains(mesh, sharp_edges(mesh));
  std::vector<std::vector<Edge>> all = chains.all();
  const auto length = [&](const std::vector<Edge>& chain) {
    double sum = 0;
    for (const Edge& edge : chain) sum += static_cast<double>(chains.vector(edge).norm());
    return sum;
  };
  const double radius = mesh.radius();
  std::erase_if(all, [&](const auto& chain) { return length(chain) < kShortest * radius; });
  double total = 0;
  for (const auto& chain : all) total += length(chain);
  const double spacing = std::max(total / static_cast<double>(most), kLeastSpacing * radius);
  std::vector<EdgeSample> samples;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::vector<Edge>& chain = all[i];
    const bool closed = chain.size() > 2 && chain.front().a == chain.back().b;
    // Of a polygon that stands for a curve, the curve's: chords turn where the curve does not.
    const auto direction_at = [&](std::size_t vertex) -> Eigen::Vector3f {
      const std::size_t count = chain.size();
      if (!closed && (vertex == 0 || vertex == count))
        return chains.vector(chain[vertex == 0 ? 0 : count - 1]).normalized();
      return (chains.vector(chain[(vertex + count - 1) % count]).normalized() +
              chains.vector(chain[vertex % count]).normalized())
          .normalized();
    };
    double next = 0.5 * spacing;  // along the chain
    for (std::size_t e = 0; e < chain.size(); ++e) {
      const Edge& edge = chain[e];
      const Eigen::Vector3f way = chains.vector(edge);
      const double end = static_cast<double>(way.norm());
      for (; next < end && samples.size() < most; next += spacing) {
        const auto share = static_cast<float>(next / end);
        const Eigen::Vector3f along = (1 - share) * direction_at(e) + share * direction_at(e + 1);
        samples.push_back(
            {mesh.positions[edge.a] + share * way, along.normalized(), edge.first, edge.second, static_cast<int>(i)});
      }
      next -= end;
    }
  }
  return samples;
}

}  // namespace holdfast
