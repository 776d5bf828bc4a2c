#include "init/surface_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace holdfast::app {
namespace {

using Eigen::Vector3d;

double squared_distance_to_edge(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double place = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
  return (a + place * along - p).squaredNorm();
}

double squared_distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  const bool above = area2 > 0 && normal.dot((b - a).cross(p - a)) >= 0 && normal.dot((c - b).cross(p - b)) >= 0 &&
                     normal.dot((a - c).cross(p - c)) >= 0;
  if (above) {
    const double height = normal.dot(p - a);
    return height * height / area2;
  }
  return std::min(
      {squared_distance_to_edge(p, a, b), squared_distance_to_edge(p, b, c), squared_distance_to_edge(p, c, a)});
}

}  // namespace

double distance_to_surface(const Mesh& mesh, const Vector3d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    least = std::min(
        least, squared_distance_to_triangle(point, mesh.positions[a].cast<double>(), mesh.positions[b].cast<double>(),
                                            mesh.positions[c].cast<double>()));
  }
  return std::sqrt(least);
}

}  // namespace holdfast::app
