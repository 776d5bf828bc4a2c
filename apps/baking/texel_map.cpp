#include "baking/texel_map.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "baking/nearest_zero.hpp"
#include "holdfast/error.hpp"

namespace holdfast::baking {
namespace {

/// Coordinates may leave the texture by rounding.
constexpr float kRounding = 1e-3F;
/// Texel centres this close to an edge (as a share of the triangle's height) belong to both triangles.
constexpr double kEdge = 1e-6;

/// Texels beyond the surface that filtering may meet, down to the mipmap level of 16.
constexpr float kPaddingReach = 16;

std::uint32_t material_of(const Mesh& mesh, std::size_t t) {
  return mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[t];
}

double surface_area(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Eigen::Vector3d p = mesh.positions[a].cast<double>();
  return 0.5 * (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm();
}

double coordinate_area(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  Eigen::Matrix2d sides;
  sides.col(0) = (mesh.texture_coordinates[b] - mesh.texture_coordinates[a]).cast<double>();
  sides.col(1) = (mesh.texture_coordinates[c] - mesh.texture_coordinates[a]).cast<double>();
  return 0.5 * std::abs(sides.determinant());
}

/// Calls visit(x, y, weights) for each texel whose centre lies in the triangle.
template <class Visit>
void rasterize(const std::array<Eigen::Vector2d, 3>& corners, const cv::Size& size, const Visit& visit) {
  Eigen::Matrix2d sides;
  sides.col(0) = corners[1] - corners[0];
  sides.col(1) = corners[2] - corners[0];
  const double determinant = sides.determinant();
  if (determinant == 0) {
    return;
  }
  const Eigen::Matrix2d inverse = sides.inverse();
  const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  // Texel x has its centre at x + 0.5.
  const int x_begin = std::max(0, static_cast<int>(std::ceil(low.x() - 0.5 - kEdge)));
  const int y_begin = std::max(0, static_cast<int>(std::ceil(low.y() - 0.5 - kEdge)));
  const int x_end = std::min(size.width, static_cast<int>(std::floor(high.x() - 0.5 + kEdge)) + 1);
  const int y_end = std::min(size.height, static_cast<int>(std::floor(high.y() - 0.5 + kEdge)) + 1);
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const Eigen::Vector2d inner = inverse * (Eigen::Vector2d(x + 0.5, y + 0.5) - corners[0]);
      const Eigen::Vector3d weights(1 - inner.x() - inner.y(), inner.x(), inner.y());
      if (weights.minCoeff() >= -kEdge) {
        visit(x, y, weights);
      }
    }
  }
}

void require_coordinates(const Mesh& mesh) {
  if (mesh.texture_coordinates.size() != mesh.positions.size()) {
    throw Error(ErrorCode::model, "the model has no texture coordinates to bake a texture for; unwrap it first");
  }
  for (const Eigen::Vector2f& coordinate : mesh.texture_coordinates) {
    if (coordinate.minCoeff() < -kRounding || coordinate.maxCoeff() > 1 + kRounding) {
      throw Error(ErrorCode::model,
                  "the model's texture coordinates leave [0, 1], so that its texture repeats and cannot be baked; "
                  "unwrap it anew (option --unwrap)");
    }
  }
}

void add_padding(TexelMap& map, const std::vector<std::uint8_t>& taken, std::size_t material) {
  const cv::Size size = map.sizes[material];
  const std::uint32_t first = map.first[material];
  cv::Mat off_surface(size, CV_8U);
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(size.width) * size.height; ++i) {
    off_surface.data[i] = taken[first + static_cast<std::size_t>(i)] != 0 ? 0 : 255;
  }
  const std::vector<std::uint32_t> nearest = nearest_zero(off_surface, kPaddingReach);
  for (std::uint32_t i = 0; i < nearest.size(); ++i) {
    if (nearest[i] != i) {
      map.padding.push_back({first + i, first + nearest[i]});
    }
  }
}

}  // namespace

TexelMap map_texels(const Mesh& mesh, const std::vector<cv::Size>& sizes) {
  mesh.validate();
  require_coordinates(mesh);
  TexelMap map;
  map.sizes = sizes;
  map.first.push_back(0);
  for (const cv::Size& size : sizes) {
    map.first.push_back(map.first.back() + static_cast<std::uint32_t>(size.area()));
  }
  std::vector<std::uint8_t> taken(map.count(), 0);
  std::vector<std::uint32_t> owner(map.count(), 0);  // where it is taken
  const float apart = 1e-3F * static_cast<float>(mesh.radius());
  map.shared.assign(map.count(), 0);
  map.triangles.push_back(0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t material = material_of(mesh, t);
    const cv::Size size = sizes.at(material);
    std::array<Eigen::Vector2d, 3> corners;
    std::array<Eigen::Vector3d, 3> p_object;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[t][k];
      const Eigen::Vector2d coordinate = mesh.texture_coordinates[vertex].cast<double>();
      corners[k] = {coordinate.x() * size.width, (1 - coordinate.y()) * size.height};
      p_object[k] = mesh.positions[vertex].cast<double>();
    }
    rasterize(corners, size, [&](int x, int y, const Eigen::Vector3d& weights) {
      const std::uint32_t texel = map.first[material] + static_cast<std::uint32_t>(y * size.width + x);
      const Eigen::Vector3f p =
          (weights[0] * p_object[0] + weights[1] * p_object[1] + weights[2] * p_object[2]).cast<float>();
      if (taken[texel] != 0) {  // on a common edge, or of two faces in one place, it is nobody's loss
        const bool elsewhere = (p - map.surface[owner[texel]].p_object).norm() > apart;
        if (weights.minCoeff() > 1e-3 && elsewhere) map.shared[texel] = 1;
        return;
      }
      taken[texel] = 1;
      owner[texel] = static_cast<std::uint32_t>(map.surface.size());
      map.surface.push_back({p, texel});
    });
    map.triangles.push_back(static_cast<std::uint32_t>(map.surface.size()));
    const double texels = coordinate_area(mesh, t) * size.area();
    map.area.push_back(texels > 0 ? static_cast<float>(surface_area(mesh, t) / texels) : 0.0F);
  }
  for (std::size_t material = 0; material < sizes.size(); ++material) {
    add_padding(map, taken, material);
  }
  return map;
}

std::vector<cv::Size> texture_sizes(const Mesh& mesh, double texels_per_metre, int largest_size) {
  require_coordinates(mesh);
  const std::size_t count = std::max<std::size_t>(1, mesh.materials.size());
  std::vector<double> surface(count, 0);
  std::vector<double> coordinates(count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    surface.at(material_of(mesh, t)) += surface_area(mesh, t);
    coordinates.at(material_of(mesh, t)) += coordinate_area(mesh, t);
  }
  std::vector<cv::Size> sizes;
  for (std::size_t m = 0; m < count; ++m) {
    double aspect = 1;
    if (m < mesh.materials.size() && !mesh.materials[m].texture.empty()) {
      aspect = static_cast<double>(mesh.materials[m].texture.width) / mesh.materials[m].texture.height;
    }
    const double texels = coordinates[m] > 0 ? surface[m] / coordinates[m] * texels_per_metre * texels_per_metre : 256;
    const auto side = [&](double value) {
      return std::clamp(static_cast<int>(std::ceil(value / 16)) * 16, 16, largest_size);
    };
    sizes.emplace_back(side(std::sqrt(texels * aspect)), side(std::sqrt(texels / aspect)));
  }
  return sizes;
}

}  // namespace holdfast::baking
