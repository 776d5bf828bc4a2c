#include "base/round_turns.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace holdfast {
namespace {

/// Share of its distance from the axis by which the hull of a round shape may change about it: a twelve-sided prism's
/// changes by 0.034, a square one's by 0.29.
constexpr double kMostUneven = 0.04;
/// Directions about an axis and, up to its poles, along it; vertices that are looked at.
constexpr int kAround = 36, kAlong = 5;
constexpr std::size_t kMostVertices = 20000;

struct Moments {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
};

/// The centre and spread of the surface are the same however it is cut into triangles.
Moments area_moments(const Mesh& mesh) {
  const Eigen::Vector3d origin = mesh.center();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  double total = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
      return mesh.positions[triangle[i]].cast<double>() - origin;
    };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    total += area;
    first += area / 3 * (a + b + c);
    // Exact for a quadratic function over a triangle.
    for (const Eigen::Vector3d& middle : {Eigen::Vector3d(a + b), Eigen::Vector3d(b + c), Eigen::Vector3d(c + a)}) {
      second += area / 12 * middle * middle.transpose();
    }
  }
  const double all = std::max(total, std::numeric_limits<double>::min());
  const Eigen::Vector3d mean = first / all;
  return {origin + mean, second / all - mean * mean.transpose()};
}

/// The convex hull stays as it is when it is turned about this axis.
bool is_round(const std::vector<Eigen::Vector3d>& arms, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d across = axis.unitOrthogonal(), other = axis.cross(across);
  double reach = 0;
  for (const Eigen::Vector3d& arm : arms) reach = std::max(reach, arm.cross(axis).norm());
  for (int i = 1; i <= kAlong; ++i) {
    const double polar = std::numbers::pi * i / (kAlong + 1);
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (int j = 0; j < kAround; ++j) {
      const double turn = 2 * std::numbers::pi * j / kAround;
      const Eigen::Vector3d d =
          std::cos(polar) * axis + std::sin(polar) * (std::cos(turn) * across + std::sin(turn) * other);
      double farthest = -std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& arm : arms) farthest = std::max(farthest, arm.dot(d));
      least = std::min(least, farthest);
      most = std::max(most, farthest);
      if (most - least > kMostUneven * reach) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<Twist> round_turns(const Mesh& mesh, const Extent& extent) {
  const Moments moments = area_moments(mesh);
  const std::size_t stride = mesh.positions.size() / kMostVertices + 1;
  std::vector<Eigen::Vector3d> arms;
  for (std::size_t i = 0; i < mesh.positions.size(); i += stride) {
    arms.push_back(mesh.positions[i].cast<double>() - moments.center);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments.spread);
  std::vector<Twist> turns;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = solver.eigenvectors().col(i);
    if (!is_round(arms, axis)) continue;
    Twist turn;
    turn << axis.cross(extent.p_object_center - moments.center) / extent.radius, axis;
    turns.push_back(turn);
  }
  return turns;
}

}  // namespace holdfast
