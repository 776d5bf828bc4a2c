#include "mesh_levels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "welded_vertices.hpp"

namespace holdfast {
namespace {

/// Fewer cost little as they are.
constexpr std::size_t kFewTriangles = 1000, kFewestTriangles = 100;
/// Of the mesh's radius.
constexpr double kMostDeviation = 0.02;
/// Least cosine between a triangle's normals before and after a step.
constexpr double kLeastCosine = 0.5;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Triangle = std::array<std::uint32_t, 3>;

/// A point of the surface: where it is (metres), where its texture is, 1.
Vector6 homogeneous(const Eigen::Vector3d& p, const Eigen::Vector2d& t) {
  return {p.x(), p.y(), p.z(), t.x(), t.y(), 1};
}

/// Area-weighted sum of squared distances, of surface and of texture (as metres on the surface), from faces' planes.
struct Quadric {
  Matrix6 Q = Matrix6::Zero();
  double area = 0;

  void operator+=(const Quadric& other) {
    Q += other.Q;
    area += other.area;
  }
  double mean_square(const Vector6& x) const { return area > 0 ? std::max(0.0, x.dot(Q * x)) / area : 0; }
};

class Simplification {
 public:
  explicit Simplification(const Mesh& mesh);

  /// Merges vertices until so many triangles are left; false when that cannot be had.
  bool reduce_to(std::size_t count, double most_deviation);
  MeshLevel level() const;
  std::size_t alive() const { return alive_; }

 private:
  struct Step {
    double cost = 0;
    std::uint32_t from = 0, to = 0, version = 0;
    /// The cheapest on top; equals in one order, so that the same mesh gives the same levels.
    bool operator<(const Step& other) const {
      return std::tie(cost, from, to) > std::tie(other.cost, other.from, other.to);
    }
  };

  void lock_borders();
  void add_quadric(std::size_t triangle, double usual_scale);
  void push_steps(std::uint32_t from);
  void push(std::uint32_t from, std::uint32_t to);
  bool allowed(std::uint32_t from, std::uint32_t to) const;
  void merge(std::uint32_t from, std::uint32_t to);
  std::vector<std::uint32_t> neighbours(std::uint32_t vertex) const;
  bool has(std::size_t triangle, std::uint32_t vertex) const {
    const Triangle& t = triangles_[triangle];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }
  std::uint32_t material(std::size_t triangle) const { return materials_.empty() ? 0 : materials_[triangle]; }
  bool textured(std::size_t triangle) const { return textured_[material(triangle)]; }
  Eigen::Vector3d cross(const Triangle& t) const {
    return (positions_[t[1]] - positions_[t[0]]).cross(positions_[t[2]] - positions_[t[0]]);
  }
  double texture_cross(const Triangle& t) const {
    const Eigen::Vector2d a = texture_[t[1]] - texture_[t[0]], b = texture_[t[2]] - texture_[t[0]];
    return a.x() * b.y() - a.y() * b.x();
  }

  std::vector<Eigen::Vector3d> positions_;
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

Simplification::Simplification(const Mesh& mesh)
    : positions_(mesh.positions.size()),
      texture_(mesh.positions.size(), Eigen::Vector2d::Zero()),
      triangles_(mesh.triangles),
      materials_(mesh.triangle_materials),
      textured_(std::max<std::size_t>(mesh.materials.size(), 1), false),
      dead_(mesh.triangles.size(), false),
      locked_(mesh.positions.size(), false),
      gone_(mesh.positions.size(), false),
      around_(mesh.positions.size()),
      quadrics_(mesh.positions.size()),
      versions_(mesh.positions.size(), 0) {
  const Eigen::Vector3d center = mesh.center();
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    positions_[i] = mesh.positions[i].cast<double>() - center;
    if (!mesh.texture_coordinates.empty()) texture_[i] = mesh.texture_coordinates[i].cast<double>();
  }
  // A texture may come later; where there are coordinates it must not slide.
  std::fill(textured_.begin(), textured_.end(), !mesh.texture_coordinates.empty());
  const std::vector<std::uint32_t> first = welded_vertices(mesh, true);
  std::vector<double> scales;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    Triangle& t = triangles_[i];
    for (std::uint32_t& vertex : t) vertex = first[vertex];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      dead_[i] = true;
      continue;
    }
    ++alive_;
    for (const std::uint32_t vertex : t) around_[vertex].push_back(static_cast<std::uint32_t>(i));
    const double of_texture = std::abs(texture_cross(t));
    if (of_texture > 0) scales.push_back(std::sqrt(cross(t).norm() / of_texture));
  }
  double usual_scale = 0;
  if (!scales.empty()) {
    const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
    std::nth_element(scales.begin(), middle, scales.end());
    usual_scale = *middle;
  }
  lock_borders();
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (!dead_[i]) add_quadric(i, usual_scale);
  }
  for (std::uint32_t i = 0; i < positions_.size(); ++i) push_steps(i);
}

void Simplification::lock_borders() {
  // An edge is inner when two triangles of one material pass it, one each way.
  struct Edge {
    std::uint32_t a, b, material;
    int direction;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * alive_);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (dead_[i]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles_[i][k], b = triangles_[i][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), material(i), a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return std::tie(x.a, x.b, x.material, x.direction) < std::tie(y.a, y.b, y.material, y.direction);
  });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b) ++end;
    const bool inner =
        end - i == 2 && edges[i].material == edges[i + 1].material && edges[i].direction + edges[i + 1].direction == 0;
    if (!inner) locked_[edges[i].a] = locked_[edges[i].b] = true;
    i = end;
  }
}

void Simplification::add_quadric(std::size_t triangle, double usual_scale) {
  const Triangle& t = triangles_[triangle];
  const Eigen::Vector3d normal = cross(t);
  const double doubled_area = normal.norm();
  if (doubled_area <= 0) {
    for (const std::uint32_t vertex : t) locked_[vertex] = true;
    return;
  }
  const Eigen::Vector3d n = normal / doubled_area, &p0 = positions_[t[0]];
  Quadric quadric;
  quadric.area = doubled_area / 6;  // a third each
  const auto add = [&](const Eigen::Vector3d& by_position, const Eigen::Vector2d& by_texture, double constant) {
    Vector6 form;
    form << by_position, by_texture, constant;
    quadric.Q += quadric.area * form * form.transpose();
  };
  add(n, Eigen::Vector2d::Zero(), -n.dot(p0));
  if (textured(triangle) && usual_scale > 0) {
    // The texture's coordinates as linear functions of the place on this face.
    Eigen::Matrix3d edges;
    edges << (positions_[t[1]] - p0).transpose(), (positions_[t[2]] - p0).transpose(), n.transpose();
    const Eigen::Matrix3d inverse = edges.inverse();
    const double of_texture = std::abs(texture_cross(t));
    const double scale = of_texture > 0
                             ? std::clamp(std::sqrt(doubled_area / of_texture), 0.1 * usual_scale, 10 * usual_scale)
                             : usual_scale;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d steps(texture_[t[1]](axis) - texture_[t[0]](axis),
                                  texture_[t[2]](axis) - texture_[t[0]](axis), 0);
      const Eigen::Vector3d gradient = inverse * steps;
      add(scale * gradient, -scale * Eigen::Vector2d::Unit(axis), scale * (texture_[t[0]](axis) - gradient.dot(p0)));
    }
  }
  for (const std::uint32_t vertex : t) quadrics_[vertex] += quadric;
}

std::vector<std::uint32_t> Simplification::neighbours(std::uint32_t vertex) const {
  std::vector<std::uint32_t> found;
  for (const std::uint32_t triangle : around_[vertex]) {
    for (const std::uint32_t other : triangles_[triangle]) {
      if (other != vertex) found.push_back(other);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void Simplification::push(std::uint32_t from, std::uint32_t to) {
  steps_.push({quadrics_[from].mean_square(homogeneous(positions_[to], texture_[to])), from, to, versions_[from]});
}

void Simplification::push_steps(std::uint32_t from) {
  if (locked_[from] || gone_[from]) return;
  for (const std::uint32_t to : neighbours(from)) push(from, to);
}

bool Simplification::allowed(std::uint32_t from, std::uint32_t to) const {
  // The two triangles between them go; more common neighbours would leave two triangles back to back.
  const std::vector<std::uint32_t> of_from = neighbours(from), of_to = neighbours(to);
  std::vector<std::uint32_t> common;
  std::set_intersection(of_from.begin(), of_from.end(), of_to.begin(), of_to.end(), std::back_inserter(common));
  if (common.size() != 2) return false;
  for (const std::uint32_t triangle : around_[from]) {
    if (has(triangle, to)) continue;
    Triangle moved = triangles_[triangle];
    std::replace(moved.begin(), moved.end(), from, to);
    const Eigen::Vector3d before = cross(triangles_[triangle]), after = cross(moved);
    if (!(before.dot(after) > kLeastCosine * before.norm() * after.norm())) return false;
    if (textured(triangle) && !(texture_cross(triangles_[triangle]) * texture_cross(moved) > 0)) return false;
  }
  return true;
}

void Simplification::merge(std::uint32_t from, std::uint32_t to) {
  const std::vector<std::uint32_t> before = neighbours(to);
  for (const std::uint32_t triangle : around_[from]) {
    if (has(triangle, to)) {
      dead_[triangle] = true;
      --alive_;
      for (const std::uint32_t vertex : triangles_[triangle]) {
        if (vertex != from) std::erase(around_[vertex], triangle);
      }
      continue;
    }
    std::replace(triangles_[triangle].begin(), triangles_[triangle].end(), from, to);
    around_[to].push_back(triangle);
  }
  around_[from].clear();
  gone_[from] = true;
  quadrics_[to] += quadrics_[from];
  ++versions_[to];
  push_steps(to);
  for (const std::uint32_t other : neighbours(to)) {
    if (!locked_[other] && !std::binary_search(before.begin(), before.end(), other)) push(other, to);
  }
}

bool Simplification::reduce_to(std::size_t count, double most_deviation) {
  while (alive_ > count) {
    if (steps_.empty()) return false;
    const Step step = steps_.top();
    if (step.cost > most_deviation * most_deviation) return false;
    steps_.pop();
    if (gone_[step.from] || gone_[step.to] || step.version != versions_[step.from]) continue;
    if (!allowed(step.from, step.to)) continue;
    worst_ = std::max(worst_, step.cost);
    merge(step.from, step.to);
  }
  return true;
}

MeshLevel Simplification::level() const {
  MeshLevel level;
  level.deviation = std::sqrt(worst_);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (dead_[i]) continue;
    level.triangles.push_back(triangles_[i]);
    if (!materials_.empty()) level.triangle_materials.push_back(materials_[i]);
  }
  return level;
}

}  // namespace

std::vector<MeshLevel> mesh_levels(const Mesh& mesh) {
  std::vector<MeshLevel> levels;
  if (mesh.triangles.size() < kFewTriangles || !mesh.colors.empty()) return levels;
  Simplification simplification(mesh);
  const double most = kMostDeviation * mesh.radius();
  while (simplification.alive() >= 2 * kFewestTriangles) {
    const std::size_t before = simplification.alive();
    const bool reached = simplification.reduce_to(before / 2, most);
    // What is left at the end of the way may still be worth a level.
    if (reached || simplification.alive() < before * 4 / 5) levels.push_back(simplification.level());
    if (!reached) break;
  }
  return levels;
}

}  // namespace holdfast
