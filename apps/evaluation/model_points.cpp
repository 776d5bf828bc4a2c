#include "evaluation/model_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace holdfast::evaluation {
namespace {

constexpr std::size_t kFewVertices = 500;
constexpr int kSurfacePoints = 2000;

std::vector<Eigen::Vector3d> distinct_vertices(const Mesh& mesh) {
  // Only what the triangles use: files carry stray vertices. Seams repeat vertices, which would weigh them double.
  std::vector<std::array<float, 3>> used;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) {
      const Eigen::Vector3f& p = mesh.positions[index];
      used.push_back({p.x(), p.y(), p.z()});
    }
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<Eigen::Vector3d> points;
  points.reserve(used.size());
  for (const auto& p : used) {
    points.emplace_back(p[0], p[1], p[2]);
  }
  return points;
}

/// Equal shares of the area, one point each, placed within the triangle by a low-discrepancy sequence.
std::vector<Eigen::Vector3d> surface_points(const Mesh& mesh, int count) {
  std::vector<double> area_up_to;
  double area = 0;
  const auto corner = [&mesh](const std::array<std::uint32_t, 3>& triangle, int i) -> Eigen::Vector3d {
    return mesh.positions[triangle[i]].cast<double>();
  };
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = corner(triangle, 0);
    area += (corner(triangle, 1) - a).cross(corner(triangle, 2) - a).norm() / 2;
    area_up_to.push_back(area);
  }
  std::vector<Eigen::Vector3d> points;
  // The plastic number's powers: the two-dimensional relative of the golden ratio.
  constexpr double kFirst = 0.7548776662466927;
  constexpr double kSecond = 0.5698402909980532;
  for (int i = 0; i < count; ++i) {
    const double wanted = area * (i + 0.5) / count;
    const auto found = std::lower_bound(area_up_to.begin(), area_up_to.end(), wanted);
    const auto& triangle = mesh.triangles[static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(found - area_up_to.begin(), std::ssize(mesh.triangles) - 1))];
    double s = std::fmod(0.5 + kFirst * i, 1.0);
    double t = std::fmod(0.5 + kSecond * i, 1.0);
    if (s + t > 1) {
      s = 1 - s;
      t = 1 - t;
    }
    const Eigen::Vector3d a = corner(triangle, 0);
    points.push_back(a + s * (corner(triangle, 1) - a) + t * (corner(triangle, 2) - a));
  }
  return points;
}

}  // namespace

double diameter(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) {
    return 0;
  }
  // Far points first: two points are no farther apart than their distances from the middle add up to, so most pairs
  // need no look.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    middle += point / static_cast<double>(points.size());
  }
  std::vector<std::pair<double, std::size_t>> far;
  for (std::size_t i = 0; i < points.size(); ++i) {
    far.emplace_back((points[i] - middle).norm(), i);
  }
  std::sort(far.rbegin(), far.rend());
  double best = 0;
  for (std::size_t i = 0; i < far.size() && 2 * far[i].first > best; ++i) {
    for (std::size_t j = i + 1; j < far.size() && far[i].first + far[j].first > best; ++j) {
      best = std::max(best, (points[far[i].second] - points[far[j].second]).norm());
    }
  }
  return best;
}

std::vector<Eigen::Vector3d> points_of(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> vertices = distinct_vertices(mesh);
  return vertices.size() >= kFewVertices ? vertices : surface_points(mesh, kSurfacePoints);
}

ModelPoints::ModelPoints(const Mesh& mesh)
    : ModelPoints(points_of(mesh), evaluation::diameter(distinct_vertices(mesh))) {}

ModelPoints::ModelPoints(std::vector<Eigen::Vector3d> points, double diameter)
    : points_(std::move(points)), diameter_(diameter), nearest_(points_) {}

double ModelPoints::add(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated) const {
  if (!T_camera_object_estimated.matrix().allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  double sum = 0;
  for (const Eigen::Vector3d& point : points_) {
    sum += (T_camera_object_true * point - T_camera_object_estimated * point).norm();
  }
  return sum / static_cast<double>(points_.size());
}

double ModelPoints::add_s(const Pose& T_camera_object_true, const Pose& T_camera_object_estimated) const {
  if (!T_camera_object_estimated.matrix().allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  // Distances do not change when both are looked at from the estimated object's frame, where the tree stands still.
  const Pose T_estimated_true = T_camera_object_estimated.inverse() * T_camera_object_true;
  double sum = 0;
  for (const Eigen::Vector3d& point : points_) {
    sum += nearest_.distance(T_estimated_true * point);
  }
  return sum / static_cast<double>(points_.size());
}

double share_below(const std::vector<double>& errors, double threshold) {
  if (errors.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto below = std::count_if(errors.begin(), errors.end(), [threshold](double e) { return e < threshold; });
  return static_cast<double>(below) / static_cast<double>(errors.size());
}

double area_under_accuracy(const std::vector<double>& errors, double maximum) {
  if (errors.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0, [maximum](double total, double error) {
    return total + std::max(0.0, 1 - error / maximum);
  });
  return sum / static_cast<double>(errors.size());
}

}  // namespace holdfast::evaluation
