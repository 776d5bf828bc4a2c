#include "render/mesh_levels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <queue>
#include <tuple>

#include "base/welded_vertices.hpp"
#include "render/quadric.hpp"

namespace holdfast {
namespace {

/// Meshes of fewer triangles cost little as they are; no level has fewer than the second.
constexpr std::size_t kFewTriangles = 1000, kFewestTriangles = 100;
/// Meshes of more triangles are thinned out to so many first.
constexpr std::size_t kManyTriangles = 50000;
/// Triangles of a level, of those of the one before, per cent.
constexpr std::size_t kLevelShare = 71;
/// Of the mesh's radius.
constexpr double kMostDeviation = 0.02;
/// Of the highest price, what thinning out begins with: no picture shows it.
constexpr double kFirstPrice = 1e-6;
/// Of how far texture lies elsewhere on the surface: it does so all ways, and hardly moves a pose.
constexpr double kTextureWeight = 0.5;
/// Least cosine between a triangle's normals before and after a step.
constexpr double kLeastCosine = 0.5;

Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return (b - a).cross(c - a);
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// A mesh while its vertices are merged.
class Simplification {
 public:
  Simplification(const Mesh& mesh, bool by_texture)
      : center_(mesh.center()),
        positions_(mesh.positions.size()),
        texture_(mesh.positions.size(), Eigen::Vector2d::Zero()),
        triangles_(mesh.triangles),
        materials_(by_texture ? mesh.triangle_materials : std::vector<std::uint32_t>{}),
        // A texture may come later; where there are coordinates it must not slide.
        textured_(by_texture && !mesh.texture_coordinates.empty()),
        dead_(mesh.triangles.size(), false),
        locked_(mesh.positions.size(), false),
        around_(mesh.positions.size()),
        quadrics_(mesh.positions.size()),
        versions_(mesh.positions.size(), 0) {
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      positions_[i] = mesh.positions[i].cast<double>() - center_;
      if (textured_) texture_[i] = mesh.texture_coordinates[i].cast<double>();
    }
    const std::vector<std::uint32_t> first = welded_vertices(mesh, textured_);
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
      if (of_texture > 0) scales.push_back(std::sqrt(surface_cross(t).norm() / of_texture));
    }
    double usual_scale = 0;
    if (!scales.empty()) {
      const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
      std::nth_element(scales.begin(), middle, scales.end());
      usual_scale = *middle;
    }
    lock_borders();
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!dead_[i]) add_quadric(triangles_[i], usual_scale);
    }
  }

  /// Merges vertices with their nearest neighbours, what costs little first by and large, until so many triangles are
  /// left: in a fifth of the time that reduce_to() takes, which keeps to the order.
  void thin_out_to(std::size_t count, double most_deviation) {
    const double most = most_deviation * most_deviation;
    std::vector<bool> taken;
    for (double dear = kFirstPrice * most; alive_ > count && dear < most;) {
      const std::size_t before = alive_;
      taken.assign(positions_.size(), false);
      for (std::uint32_t from = 0; from < positions_.size() && alive_ > count; ++from) {
        if (locked_[from] || taken[from]) continue;
        const std::uint32_t to = nearest(from, taken);
        if (to == from) continue;
        const Quadric::Vector6 x = merged(from, to);
        const double price = cost(from, to, x);
        if (price > dear || !allowed(from, to, x)) continue;
        merge(from, to, x, price);
        taken[to] = true;
      }
      if (alive_ > before * 9 / 10) dear *= 4;
    }
  }

  /// Prepares reduce_to().
  void push_all() {
    for (std::uint32_t i = 0; i < positions_.size(); ++i) {
      for (const std::uint32_t other : neighbours(i)) {
        if (i < other) push(i, other);
      }
    }
  }

  /// Merges vertices in the order of what that costs until so many triangles are left; false when that cannot be had.
  bool reduce_to(std::size_t count, double most_deviation) {
    while (alive_ > count) {
      if (steps_.empty()) return false;
      const Step step = steps_.top();
      if (step.cost > most_deviation * most_deviation) return false;
      steps_.pop();
      if (step.version_from != versions_[step.from] || step.version_to != versions_[step.to]) continue;
      const Quadric::Vector6 x = merged(step.from, step.to);
      if (!allowed(step.from, step.to, x)) continue;
      merge(step.from, step.to, x, step.cost);
      for (const std::uint32_t other : neighbours(step.to)) push(step.to, other);
    }
    return true;
  }

  MeshLevel level() const {
    MeshLevel level;
    level.deviation = std::sqrt(worst_);
    constexpr std::uint32_t kUnused = ~std::uint32_t{0};
    std::vector<std::uint32_t> place(positions_.size(), kUnused);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (dead_[i]) continue;
      Triangle triangle = triangles_[i];
      for (std::uint32_t& vertex : triangle) {
        std::uint32_t& at = place[vertex];
        if (at == kUnused) {
          at = static_cast<std::uint32_t>(level.positions.size());
          level.positions.push_back(positions_[vertex] + center_);
          if (textured_) level.texture_coordinates.push_back(texture_[vertex].cast<float>());
        }
        vertex = at;
      }
      level.triangles.push_back(triangle);
      if (!materials_.empty()) level.triangle_materials.push_back(materials_[i]);
    }
    return level;
  }

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

  void lock_borders() {
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
        edges.push_back({std::min(a, b), std::max(a, b), materials_.empty() ? 0 : materials_[i], a < b ? 1 : -1});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
      return std::tie(x.a, x.b, x.material, x.direction) < std::tie(y.a, y.b, y.material, y.direction);
    });
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
      while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b) ++end;
      const bool inner = end - i == 2 && edges[i].material == edges[i + 1].material &&
                         edges[i].direction + edges[i + 1].direction == 0;
      if (!inner) locked_[edges[i].a] = locked_[edges[i].b] = true;
    }
  }

  void add_quadric(const Triangle& t, double usual_scale) {
    const Eigen::Vector3d normal = surface_cross(t);
    const double doubled_area = normal.norm();
    if (doubled_area <= 0) {
      for (const std::uint32_t vertex : t) locked_[vertex] = true;
      return;
    }
    const Eigen::Vector3d n = normal / doubled_area, &p0 = positions_[t[0]];
    Quadric quadric;
    quadric.area = doubled_area / 6;  // a third each
    const auto add = [&](const Eigen::Vector3d& by_position, const Eigen::Vector2d& by_texture, double constant) {
      Quadric::Vector6 form;
      form << by_position, by_texture, constant;
      quadric.Q += quadric.area * form * form.transpose();
    };
    add(n, Eigen::Vector2d::Zero(), -n.dot(p0));
    if (textured_ && usual_scale > 0) {
      // The texture's coordinates as linear functions of the place on this face.
      Eigen::Matrix3d edges;
      edges << (positions_[t[1]] - p0).transpose(), (positions_[t[2]] - p0).transpose(), n.transpose();
      const Eigen::Matrix3d inverse = edges.inverse();
      const double of_texture = std::abs(texture_cross(t));
      const double on_surface =
          of_texture > 0 ? std::clamp(std::sqrt(doubled_area / of_texture), 0.1 * usual_scale, 10 * usual_scale)
                         : usual_scale;
      const double scale = kTextureWeight * on_surface;
      for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector3d steps(texture_[t[1]](axis) - texture_[t[0]](axis),
                                    texture_[t[2]](axis) - texture_[t[0]](axis), 0);
        const Eigen::Vector3d gradient = inverse * steps;
        add(scale * gradient, -scale * Eigen::Vector2d::Unit(axis), scale * (texture_[t[0]](axis) - gradient.dot(p0)));
      }
    }
    for (const std::uint32_t vertex : t) quadrics_[vertex] += quadric;
  }

  std::vector<std::uint32_t> neighbours(std::uint32_t vertex) const {
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

  /// The vertex that is nearest along an edge, of those that are not in `taken`; itself when there is none.
  std::uint32_t nearest(std::uint32_t vertex, const std::vector<bool>& taken) const {
    std::uint32_t found = vertex;
    double least = std::numeric_limits<double>::max();
    for (const std::uint32_t triangle : around_[vertex]) {
      for (const std::uint32_t other : triangles_[triangle]) {
        if (other == vertex || taken[other]) continue;
        const double square = (positions_[other] - positions_[vertex]).squaredNorm();
        if (square < least || (square == least && other < found)) {
          least = square;
          found = other;
        }
      }
    }
    return found;
  }

  /// Where both become one; on the other where that is locked.
  Quadric::Vector6 merged(std::uint32_t from, std::uint32_t to) const {
    if (locked_[to]) return point(to);
    // What the triangles around both enclose stays as it is (Lindstrom and Turk, 1998): otherwise they cut corners, and
    // the body shrinks.
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    double volume = 0, all = 0;
    const auto add = [&](const Triangle& triangle) {
      const Eigen::Vector3d normal = surface_cross(triangle);
      area += normal;
      volume += normal.dot(positions_[triangle[0]]);
      all += normal.norm();
    };
    for (const std::uint32_t triangle : around_[from]) add(triangles_[triangle]);
    for (const std::uint32_t triangle : around_[to]) {
      if (!has(triangle, from)) add(triangles_[triangle]);
    }
    // Where they look all ways no height tells.
    const double length = area.norm();
    const bool faces_one_way = length > 0.5 * all;
    Quadric both = quadrics_[from];
    both += quadrics_[to];
    return both.best_near(0.5 * (point(from) + point(to)),
                          faces_one_way ? Eigen::Vector3d(area / length) : Eigen::Vector3d::Zero(),
                          faces_one_way ? volume / length : 0);
  }

  double cost(std::uint32_t from, std::uint32_t to, const Quadric::Vector6& x) const {
    return std::max(quadrics_[from].mean_square(x), quadrics_[to].mean_square(x));
  }

  void push(std::uint32_t a, std::uint32_t b) {
    if (locked_[a] && locked_[b]) return;
    if (locked_[a]) std::swap(a, b);
    steps_.push({cost(a, b, merged(a, b)), a, b, versions_[a], versions_[b]});
  }

  /// Whether the triangles around a vertex that the other has no part in stay as they are but for it.
  bool stay(std::uint32_t vertex, std::uint32_t other, const Quadric::Vector6& x) const {
    const Eigen::Vector3d p = x.head<3>();
    const Eigen::Vector2d texture = x.segment<2>(3);
    for (const std::uint32_t triangle : around_[vertex]) {
      if (has(triangle, other)) continue;
      const Triangle& t = triangles_[triangle];
      const auto place = [&](std::size_t k) { return t[k] == vertex ? p : positions_[t[k]]; };
      const Eigen::Vector3d before = surface_cross(t), after = cross(place(0), place(1), place(2));
      if (!(before.dot(after) > kLeastCosine * before.norm() * after.norm())) return false;
      if (!textured_) continue;
      const auto texel = [&](std::size_t k) { return t[k] == vertex ? texture : texture_[t[k]]; };
      if (!(texture_cross(t) * cross(texel(0), texel(1), texel(2)) > 0)) return false;
    }
    return true;
  }

  bool allowed(std::uint32_t from, std::uint32_t to, const Quadric::Vector6& x) const {
    // The two triangles between them go; more common neighbours would leave two triangles back to back.
    const std::vector<std::uint32_t> of_from = neighbours(from), of_to = neighbours(to);
    std::vector<std::uint32_t> common;
    std::set_intersection(of_from.begin(), of_from.end(), of_to.begin(), of_to.end(), std::back_inserter(common));
    return common.size() == 2 && stay(from, to, x) && (locked_[to] || stay(to, from, x));
  }

  void merge(std::uint32_t from, std::uint32_t to, const Quadric::Vector6& x, double price) {
    worst_ = std::max(worst_, price);
    positions_[to] = x.head<3>();
    texture_[to] = x.segment<2>(3);
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
    quadrics_[to] += quadrics_[from];
    ++versions_[from];
    ++versions_[to];
  }

  Quadric::Vector6 point(std::uint32_t vertex) const {
    Quadric::Vector6 x;
    x << positions_[vertex], texture_[vertex], 1;
    return x;
  }
  bool has(std::uint32_t triangle, std::uint32_t vertex) const {
    const Triangle& t = triangles_[triangle];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }
  Eigen::Vector3d surface_cross(const Triangle& t) const {
    return cross(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  }
  double texture_cross(const Triangle& t) const { return cross(texture_[t[0]], texture_[t[1]], texture_[t[2]]); }

  Eigen::Vector3d center_;
  std::vector<Eigen::Vector3d> positions_;  ///< about it
  std::vector<Eigen::Vector2d> texture_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> materials_;
  bool textured_;
  std::vector<bool> dead_, locked_;
  std::vector<std::vector<std::uint32_t>> around_;  ///< triangles of a vertex; none: it has become another
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> versions_;
  std::priority_queue<Step> steps_;
  std::size_t alive_ = 0;
  double worst_ = 0;  ///< mean square
};

}  // namespace

std::vector<MeshLevel> mesh_levels(const Mesh& mesh, MeshAspect aspect) {
  std::vector<MeshLevel> levels;
  const bool looks = aspect == MeshAspect::appearance;
  if (mesh.triangles.size() < kFewTriangles || (looks && !mesh.colors.empty())) return levels;
  Simplification simplification(mesh, looks);
  const double most = kMostDeviation * mesh.radius();
  if (simplification.alive() > kManyTriangles) {
    simplification.thin_out_to(kManyTriangles, most);
    levels.push_back(simplification.level());
  }
  simplification.push_all();
  while (simplification.alive() >= 2 * kFewestTriangles) {
    const std::size_t before = simplification.alive();
    const bool reached = simplification.reduce_to(before * kLevelShare / 100, most);
    // What is left at the end of the way may still be worth a level.
    if (reached || simplification.alive() < before * 9 / 10) levels.push_back(simplification.level());
    if (!reached) break;
  }
  return levels;
}

}  // namespace holdfast
