#include "io/polygon.hpp"

#include <Eigen/Geometry>
#include <numeric>

namespace holdfast::io {
namespace {

/// Corners of a polygon that is cut into ears; larger ones, whose cutting would take minutes, are fans.
constexpr std::size_t kMostCorners = 500;

using Corners = std::vector<Eigen::Vector2d>;

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The corners in the polygon's own plane, turning to the left.
Corners flattened(const std::vector<Eigen::Vector3f>& corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d first = corners[0].cast<double>();
  for (std::size_t i = 2; i < corners.size(); ++i) {
    normal += (corners[i - 1].cast<double>() - first).cross(corners[i].cast<double>() - first);
  }
  if (!(normal.norm() > 0)) {
    return {};
  }
  const Eigen::Vector3d x = normal.unitOrthogonal();
  const Eigen::Vector3d y = normal.normalized().cross(x);
  Corners flat;
  for (const Eigen::Vector3f& corner : corners) {
    const Eigen::Vector3d offset = corner.cast<double>() - first;
    flat.push_back({offset.dot(x), offset.dot(y)});
  }
  return flat;
}

bool is_convex(const Corners& flat) {
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (turn(flat[i], flat[(i + 1) % flat.size()], flat[(i + 2) % flat.size()]) < 0) {
      return false;
    }
  }
  return true;
}

/// Whether the corner at `i` of those that remain can be cut off: it turns outwards and no other lies within.
bool is_ear(const Corners& flat, const std::vector<std::size_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  const std::size_t before = left[(i + n - 1) % n], here = left[i], after = left[(i + 1) % n];
  const Eigen::Vector2d &a = flat[before], &b = flat[here], &c = flat[after];
  if (!(turn(a, b, c) > 0)) {
    return false;
  }
  for (const std::size_t other : left) {
    const Eigen::Vector2d& p = flat[other];
    const bool is_corner = p == a || p == b || p == c;
    if (!is_corner && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::vector<std::array<std::size_t, 3>> triangles_of_polygon(const std::vector<Eigen::Vector3f>& corners) {
  std::vector<std::array<std::size_t, 3>> triangles;
  std::vector<std::size_t> left(corners.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  if (corners.size() > 3 && corners.size() <= kMostCorners) {
    const Corners flat = flattened(corners);
    const bool cut = !flat.empty() && !is_convex(flat);
    for (std::size_t i = 0; cut && left.size() > 3 && i < left.size();) {
      if (is_ear(flat, left, i)) {
        triangles.push_back({left[(i + left.size() - 1) % left.size()], left[i], left[(i + 1) % left.size()]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
        i = 0;
      } else {
        ++i;
      }
    }
  }
  for (std::size_t i = 2; i < left.size(); ++i) {  // a convex one, and what crosses itself
    triangles.push_back({left[0], left[i - 1], left[i]});
  }
  return triangles;
}

}  // namespace holdfast::io
