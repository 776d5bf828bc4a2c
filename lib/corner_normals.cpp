#include "corner_normals.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "welded_vertices.hpp"

namespace holdfast {
namespace {

constexpr double kSmoothCosine = 0.766;  // 40 degrees
/// Of a fan of more triangles, most often a flat one, each keeps its own: all would be compared with all.
constexpr std::size_t kMostAround = 1000;

}  // namespace

std::vector<std::array<Eigen::Vector3f, 3>> corner_normals(const std::vector<Eigen::Vector3d>& positions,
                                                           const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const std::vector<std::uint32_t> welded = welded_positions(positions);
  std::vector<Eigen::Vector3d> normals(triangles.size());
  // Of the corners at each position, one list after the other: their triangle and how wide they are.
  struct Corner {
    std::uint32_t triangle;
    double angle;
  };
  std::vector<std::size_t> first(positions.size() + 1, 0);
  for (const auto& triangle : triangles) {
    for (const std::uint32_t vertex : triangle) ++first[welded[vertex] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  std::vector<Corner> around(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto edge = [&](std::size_t from, std::size_t to) -> Eigen::Vector3d {
      return positions[triangles[i][to % 3]] - positions[triangles[i][from]];
    };
    normals[i] = edge(0, 1).cross(edge(0, 2)).normalized();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d one = edge(corner, corner + 1), other = edge(corner, corner + 2);
      around[next[welded[triangles[i][corner]]]++] = {static_cast<std::uint32_t>(i),
                                                      std::atan2(one.cross(other).norm(), one.dot(other))};
    }
  }
  std::vector<std::array<Eigen::Vector3f, 3>> smooth(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t place = welded[triangles[i][corner]];
      if (first[place + 1] - first[place] > kMostAround) {
        smooth[i][corner] = normals[i].cast<float>();
        continue;
      }
      // Always in the same order, so that corners of one smooth surface have the same normal to the last bit.
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t k = first[place]; k < first[place + 1]; ++k) {
        const Eigen::Vector3d& normal = normals[around[k].triangle];
        if (normal.dot(normals[i]) >= kSmoothCosine) sum += around[k].angle * normal;
      }
      smooth[i][corner] = sum.normalized().cast<float>();
    }
  }
  return smooth;
}

}  // namespace holdfast
