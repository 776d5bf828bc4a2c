#include "base/welded_vertices.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace holdfast {

std::vector<std::uint32_t> welded_vertices(const Mesh& mesh, bool by_texture) {
  by_texture = by_texture && !mesh.texture_coordinates.empty();
  const auto key = [&](std::uint32_t i) {
    const Eigen::Vector3f& p = mesh.positions[i];
    const Eigen::Vector2f t = by_texture ? mesh.texture_coordinates[i] : Eigen::Vector2f(0, 0);
    return std::array{p.x(), p.y(), p.z(), t.x(), t.y()};
  };
  std::vector<std::uint32_t> order(mesh.positions.size()), welded(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    welded[order[i]] = same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

}  // namespace holdfast
