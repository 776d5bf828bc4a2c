#include "baking/charts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace holdfast::baking {
namespace {

/// A triangle turned farther than this from the axis would be pressed too thin to hold a texture, radians.
constexpr double kSteepest = 1.15;
/// Triangles laid flat count as overlapping when they share more than this share of their size in every direction.
constexpr double kOverlap = 1e-4;

/// Rounds of averaging over neighbours that tell a surface's direction from its roughness, and angles that count as
/// equal then, radians.
constexpr int kSmoothing = 8;
constexpr double kRoughnessStep = 0.1;

using Corners = std::array<Eigen::Vector2d, 3>;

Eigen::Vector2d extent_along(const Corners& corners, const Eigen::Vector2d& direction) {
  const double a = corners[0].dot(direction);
  const double b = corners[1].dot(direction);
  const double c = corners[2].dot(direction);
  return {std::min({a, b, c}), std::max({a, b, c})};
}

/// Separating axes: triangles that only touch, at an edge or a corner, do not overlap.
bool overlap(const Corners& a, const Corners& b) {
  for (const Corners* triangle : {&a, &b}) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d edge = (*triangle)[(k + 1) % 3] - (*triangle)[k];
      const double length = edge.norm();
      if (length == 0) {
        return false;
      }
      const Eigen::Vector2d across(-edge.y() / length, edge.x() / length);
      const Eigen::Vector2d of_a = extent_along(a, across);
      const Eigen::Vector2d of_b = extent_along(b, across);
      const double common = std::min(of_a[1], of_b[1]) - std::max(of_a[0], of_b[0]);
      if (common <= kOverlap * std::min(of_a[1] - of_a[0], of_b[1] - of_b[0])) {
        return false;
      }
    }
  }
  return true;
}

/// Flat triangles by the cells of a grid that they touch.
class FlatTriangles {
 public:
  explicit FlatTriangles(double cell) : cell_(cell) {}

  /// Adds it unless it overlaps one that is there.
  bool add(const Corners& corners) {
    const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const auto for_cells = [&](const auto& visit) {
      for (std::int64_t y = index(low.y()); y <= index(high.y()); ++y) {
        for (std::int64_t x = index(low.x()); x <= index(high.x()); ++x) {
          if (!visit((y << 32) ^ (x & 0xffffffff))) {
            return false;
          }
        }
      }
      return true;
    };
    const bool free = for_cells([&](std::int64_t key) {
      const auto found = cells_.find(key);
      return found == cells_.end() ||
             std::none_of(found->second.begin(), found->second.end(),
                          [&](std::uint32_t other) { return overlap(corners, triangles_[other]); });
    });
    if (!free) {
      return false;
    }
    const auto number = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(corners);
    for_cells([&](std::int64_t key) {
      cells_[key].push_back(number);
      return true;
    });
    return true;
  }

 private:
  std::int64_t index(double coordinate) const { return static_cast<std::int64_t>(std::floor(coordinate / cell_)); }

  double cell_;
  std::vector<Corners> triangles_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
};

class ChartMaker {
 public:
  ChartMaker(const Mesh& mesh, const MeshTopology& topology, double cone)
      : mesh_(mesh), topology_(topology), cosine_(std::cos(cone)), chart_of_(mesh.triangles.size(), -1) {}

  std::vector<Chart> make(double least_extent) {
    grow_all();
    absorb_small(least_extent);
    return separated();
  }

 private:
  /// Connected free triangles within the cone round the axis, from the seed on.
  std::vector<std::uint32_t> grow(std::uint32_t seed, const Eigen::Vector3d& axis, std::int32_t chart) {
    std::vector<std::uint32_t> members{seed};
    chart_of_[seed] = chart;
    for (std::size_t next = 0; next < members.size(); ++next) {
      for (const std::int32_t neighbor : topology_.neighbors[members[next]]) {
        if (neighbor < 0 || chart_of_[neighbor] >= 0 || topology_.areas[neighbor] <= 0 ||
            topology_.normals[neighbor].dot(axis) < cosine_) {
          continue;
        }
        chart_of_[neighbor] = chart;
        members.push_back(static_cast<std::uint32_t>(neighbor));
      }
    }
    return members;
  }

  Eigen::Vector3d mean_normal(const std::vector<std::uint32_t>& members) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::uint32_t t : members) {
      sum += topology_.areas[t] * topology_.normals[t];
    }
    return sum.normalized();
  }

  /// How far each triangle is turned from the surface around it, radians.
  std::vector<double> roughness() const {
    std::vector<Eigen::Vector3d> smooth = topology_.normals;
    std::vector<Eigen::Vector3d> sums(smooth.size());
    for (int pass = 0; pass < kSmoothing; ++pass) {
      for (std::size_t t = 0; t < smooth.size(); ++t) {
        sums[t] = topology_.areas[t] * smooth[t];
        for (const std::int32_t neighbor : topology_.neighbors[t]) {
          if (neighbor >= 0) {
            sums[t] += topology_.areas[neighbor] * smooth[neighbor];
          }
        }
      }
      for (std::size_t t = 0; t < smooth.size(); ++t) {
        smooth[t] = sums[t].normalized();
      }
    }
    std::vector<double> angles(smooth.size());
    for (std::size_t t = 0; t < smooth.size(); ++t) {
      angles[t] = std::acos(std::clamp(smooth[t].dot(topology_.normals[t]), -1.0, 1.0));
    }
    return angles;
  }

  /// From triangles that face as their surroundings do, the large ones first: they carry the planes that a box or a
  /// tool consists of, and the middle of what is rough.
  void grow_all() {
    const std::vector<double> rough = roughness();
    const auto order = [&](std::uint32_t t) {
      return std::make_pair(std::floor(rough[t] / kRoughnessStep), -topology_.areas[t]);
    };
    std::vector<std::uint32_t> seeds(mesh_.triangles.size());
    std::iota(seeds.begin(), seeds.end(), 0U);
    std::stable_sort(seeds.begin(), seeds.end(),
                     [&](std::uint32_t left, std::uint32_t right) { return order(left) < order(right); });
    for (const std::uint32_t seed : seeds) {
      if (chart_of_[seed] >= 0 || topology_.areas[seed] <= 0) {
        continue;
      }
      const auto chart = static_cast<std::int32_t>(charts_.size());
      // About the seed's normal first, then about the middle of what that found, which holds the seed too.
      const std::vector<std::uint32_t> found = grow(seed, topology_.normals[seed], chart);
      const Eigen::Vector3d axis = mean_normal(found);
      for (const std::uint32_t t : found) {
        chart_of_[t] = -1;
      }
      charts_.push_back({axis, grow(seed, axis, chart)});
    }
  }

  double extent(const Chart& chart) const {
    double area = 0;
    for (const std::uint32_t t : chart.triangles) {
      area += topology_.areas[t];
    }
    return std::sqrt(area);
  }

  /// Rough surfaces leave crumbs, each of which would cost the padding of a chart.
  void absorb_small(double least_extent) {
    for (std::size_t c = 0; c < charts_.size(); ++c) {
      if (extent(charts_[c]) >= least_extent) {
        continue;
      }
      bool moved = true;
      while (moved) {
        moved = false;
        std::vector<std::uint32_t> left;
        for (const std::uint32_t t : charts_[c].triangles) {
          const std::int32_t host = flattest_neighbor(t);
          if (host < 0) {
            left.push_back(t);
            continue;
          }
          charts_[static_cast<std::size_t>(host)].triangles.push_back(t);
          chart_of_[t] = host;
          moved = true;
        }
        charts_[c].triangles = std::move(left);
      }
    }
  }

  /// The chart next to a triangle, not its own, whose axis is nearest to its normal; -1 where that is too steep.
  std::int32_t flattest_neighbor(std::uint32_t t) const {
    std::int32_t best = -1;
    double best_cosine = std::cos(kSteepest);
    for (const std::int32_t neighbor : topology_.neighbors[t]) {
      if (neighbor < 0 || chart_of_[neighbor] < 0 || chart_of_[neighbor] == chart_of_[t]) {
        continue;
      }
      const Chart& host = charts_[static_cast<std::size_t>(chart_of_[neighbor])];
      const double cosine = topology_.normals[t].dot(host.axis);
      if (cosine > best_cosine) {
        best_cosine = cosine;
        best = chart_of_[neighbor];
      }
    }
    return best;
  }

  /// What would lie on top of another triangle of its chart (a winding staircase) makes further charts.
  std::vector<Chart> separated() const {
    std::vector<Chart> result;
    for (const Chart& chart : charts_) {
      const ChartPlane plane(chart.axis);
      std::vector<std::uint32_t> waiting = chart.triangles;
      while (!waiting.empty()) {
        FlatTriangles flat(cell_size(waiting, plane));
        Chart layer;
        layer.axis = chart.axis;
        std::vector<std::uint32_t> above;
        for (const std::uint32_t t : waiting) {
          (flat.add(corners(t, plane)) ? layer.triangles : above).push_back(t);
        }
        result.push_back(std::move(layer));
        waiting = std::move(above);
      }
    }
    return result;
  }

  Corners corners(std::uint32_t t, const ChartPlane& plane) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    return {plane.project(mesh_.positions[a]), plane.project(mesh_.positions[b]), plane.project(mesh_.positions[c])};
  }

  /// Cells of about one triangle each.
  double cell_size(const std::vector<std::uint32_t>& members, const ChartPlane& plane) const {
    Eigen::Vector2d low = corners(members.front(), plane)[0];
    Eigen::Vector2d high = low;
    for (const std::uint32_t t : members) {
      for (const Eigen::Vector2d& corner : corners(t, plane)) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    }
    return (high - low).maxCoeff() / std::sqrt(static_cast<double>(members.size()));
  }

  const Mesh& mesh_;
  const MeshTopology& topology_;
  double cosine_;
  std::vector<std::int32_t> chart_of_;  // a triangle; -1: none yet
  std::vector<Chart> charts_;
};

}  // namespace

ChartPlane::ChartPlane(const Eigen::Vector3d& axis) : right(axis.unitOrthogonal()), down(right.cross(axis)) {}

std::vector<Chart> make_charts(const Mesh& mesh, const MeshTopology& topology, double cone, double least_extent) {
  return ChartMaker(mesh, topology, cone).make(least_extent);
}

}  // namespace holdfast::baking
