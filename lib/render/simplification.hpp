#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <queue>
#include <tuple>
#include <vector>

#include "holdfast/mesh.hpp"
#include "render/mesh_levels.hpp"

namespace holdfast {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Area-weighted sum of squared distances, of surface and of texture (as metres on the surface), from faces' planes;
/// of points given by where they are (metres), where their texture is, 1.
struct Quadric {
  Matrix6 Q = Matrix6::Zero();
  double area = 0;

  void operator+=(const Quadric& other) {
    Q += other.Q;
    area += other.area;
  }
  double mean_square(const Vector6& x) const { return area > 0 ? std::max(0.0, x.dot(Q * x)) / area : 0; }
  /// Of the points at this `height` along `normal` (metres; a zero normal: of all) the one of least distance, near x.
  Vector6 best_near(const Vector6& x, const Eigen::Vector3d& normal, double height) const;
};

/// A mesh while its vertices are merged.
class Simplification {
 public:
  Simplification(const Mesh& mesh, bool by_texture);

  /// Merges vertices with their nearest neighbours, what costs little first by and large, until so many triangles are
  /// left: in a tenth of the time that reduce_to() takes, which keeps to the order.
  void thin_out_to(std::size_t count, double most_deviation);
  /// Prepares reduce_to().
  void push_all();
  /// Merges vertices in the order of what that costs until so many triangles are left; false when that cannot be had.
  bool reduce_to(std::size_t count, double most_deviation);
  MeshLevel level() const;
  std::size_t alive() const { return alive_; }

 private:
  using Triangle = std::array<std::uint32_t, 3>;

  struct Step {
    double cost = 0;
    std::uint32_t from = 0, to = 0, version_from = 0, version_to = 0;
    /// The cheapest on top; equals in one order, so that the same mesh gives the same levels.
    bool operator<(const Step& other) const {
      return std::tie(cost, from, to) > std::tie(other.cost, other.from, other.to);
    }
  };

  void lock_borders();
  void add_quadric(std::size_t triangle, double usual_scale);
  void push(std::uint32_t a, std::uint32_t b);
  /// The vertex that is nearest along an edge, of those that are not in `taken`; itself when there is none.
  std::uint32_t nearest(std::uint32_t vertex, const std::vector<bool>& taken) const;
  double cost(std::uint32_t from, std::uint32_t to, const Vector6& x) const {
    return std::max(quadrics_[from].mean_square(x), quadrics_[to].mean_square(x));
  }
  /// What merging with the nearest vertex costs at most for half of the vertices, from a sample of them.
  double usual_cost(const std::vector<bool>& taken) const;
  /// Where both become one; on the other where that is locked.
  Vector6 merged(std::uint32_t from, std::uint32_t to) const;
  bool allowed(std::uint32_t from, std::uint32_t to, const Vector6& x) const;
  /// Whether the triangles around a vertex that the other has no part in stay as they are but for it.
  bool stay(std::uint32_t vertex, std::uint32_t other, const Vector6& x) const;
  void merge(std::uint32_t from, std::uint32_t to, const Vector6& x);
  Vector6 point(std::uint32_t vertex) const {
    const Eigen::Vector3d& p = positions_[vertex];
    const Eigen::Vector2d& t = texture_[vertex];
    return {p.x(), p.y(), p.z(), t.x(), t.y(), 1};
  }
  std::vector<std::uint32_t> neighbours(std::uint32_t vertex) const;
  bool has(std::size_t triangle, std::uint32_t vertex) const {
    const Triangle& t = triangles_[triangle];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }
  std::uint32_t material(std::size_t triangle) const { return materials_.empty() ? 0 : materials_[triangle]; }
  bool textured(std::size_t triangle) const { return textured_[material(triangle)]; }
  static Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return (b - a).cross(c - a);
  }
  static double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  }
  Eigen::Vector3d cross(const Triangle& t) const { return cross(positions_[t[0]], positions_[t[1]], positions_[t[2]]); }
  double texture_cross(const Triangle& t) const { return cross(texture_[t[0]], texture_[t[1]], texture_[t[2]]); }

  Eigen::Vector3d center_;
  std::vector<Eigen::Vector3d> positions_;  ///< about it
  std::vector<Eigen::Vector2d> texture_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> materials_;
  std::vector<bool> textured_, dead_, locked_, gone_;
  std::vector<std::vector<std::uint32_t>> around_;  ///< triangles of a vertex
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> versions_;
  std::priority_queue<Step> steps_;
  std::size_t alive_ = 0;
  double worst_ = 0;  ///< mean square
};

}  // namespace holdfast
