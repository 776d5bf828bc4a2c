#include "render/enlarged_texture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace holdfast {
namespace {

/// An enlarged texture's texels at most: 16 MiB.
constexpr std::int64_t kMostTexels = std::int64_t{1} << 22;
constexpr int kMostEnlargement = 4;

/// The two texels that one of the enlarged lies between, and what the second weighs, in 1/(2 times).
struct Between {
  int first = 0, second = 0;
  std::uint32_t weight = 0;
};

std::vector<Between> between(int size, int times, bool repeat) {
  std::vector<Between> result(static_cast<std::size_t>(size) * static_cast<std::size_t>(times));
  for (std::size_t i = 0; i < result.size(); ++i) {
    // Its centre, in 1/(2 times) of a texel from the first one's centre.
    const int place = 2 * static_cast<int>(i) + 1 - times;
    const int first = place < 0 ? -1 : place / (2 * times);
    const auto inside = [&](int texel) { return repeat ? (texel + size) % size : std::clamp(texel, 0, size - 1); };
    result[i] = {inside(first), inside(first + 1), static_cast<std::uint32_t>(place - 2 * times * first)};
  }
  return result;
}

}  // namespace

std::vector<double> texture_densities(const Mesh& mesh) {
  std::vector<double> surface(mesh.materials.size()), texture(mesh.materials.size());
  if (mesh.texture_coordinates.empty()) return texture;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[i];
    if (material >= surface.size()) continue;
    const Eigen::Vector3d p = mesh.positions[a].cast<double>();
    surface[material] += (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm();
    const Eigen::Vector2d t = mesh.texture_coordinates[a].cast<double>();
    const Eigen::Vector2d to_b = mesh.texture_coordinates[b].cast<double>() - t;
    const Eigen::Vector2d to_c = mesh.texture_coordinates[c].cast<double>() - t;
    texture[material] += std::abs(to_b.x() * to_c.y() - to_b.y() * to_c.x());
  }
  for (std::size_t i = 0; i < surface.size(); ++i) texture[i] = surface[i] > 0 ? texture[i] / surface[i] : 0;
  return texture;
}

int enlargement(const Texture& texture, double density, double longest, int largest_side) {
  if (texture.empty() || !(density > 0)) return 1;
  const double texel = 1 / std::sqrt(density * texture.width * texture.height);
  int times = 1;
  while (times < kMostEnlargement && texel / times > longest) {
    const std::int64_t wider = std::int64_t{2} * times * texture.width,
                       higher = std::int64_t{2} * times * texture.height;
    if (std::max(wider, higher) > largest_side || wider * higher > kMostTexels) break;
    times *= 2;
  }
  return times;
}

Texture enlarged(const Texture& texture, int times, bool repeat, const LightEncoding& encoding) {
  const std::vector<Between> columns = between(texture.width, times, repeat);
  const std::vector<Between> rows = between(texture.height, times, repeat);
  Texture result{texture.width * times, texture.height * times, {}};
  result.rgba.resize(columns.size() * rows.size() * 4);
  // Light of colours, share of alpha, 65535 is all; of the two rows between which the enlarged ones lie, interpolated
  // along them.
  using Row = std::vector<std::array<std::uint32_t, 4>>;
  const std::uint32_t whole = 2 * static_cast<std::uint32_t>(times);
  const auto along = [&](int row) {
    Row line(columns.size());
    const std::uint8_t* texels =
        texture.rgba.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) * 4;
    const auto value = [&](int column, std::size_t channel) {
      const std::uint8_t encoded = texels[static_cast<std::size_t>(column) * 4 + channel];
      return static_cast<std::uint32_t>(channel < 3 ? encoding.light(encoded) : encoded * 257);
    };
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Between& column = columns[i];
      for (std::size_t channel = 0; channel < 4; ++channel) {
        line[i][channel] =
            (whole - column.weight) * value(column.first, channel) + column.weight * value(column.second, channel);
      }
    }
    return line;
  };
  int held = -1, held_after = -1;
  Row first, second;
  std::uint8_t* out = result.rgba.data();
  for (const Between& row : rows) {
    if (row.first != held || row.second != held_after) {
      first = row.first == held_after ? std::move(second) : along(row.first);
      second = along(row.second);
      held = row.first;
      held_after = row.second;
    }
    for (std::size_t i = 0; i < columns.size(); ++i, out += 4) {
      for (std::size_t channel = 0; channel < 4; ++channel) {
        const std::uint32_t sum = (whole - row.weight) * first[i][channel] + row.weight * second[i][channel];
        const std::uint32_t mean = (sum + whole * whole / 2) / (whole * whole);
        out[channel] = channel < 3 ? encoding.encoded(static_cast<std::uint16_t>(mean))
                                   : static_cast<std::uint8_t>((mean + 128) / 257);
      }
    }
  }
  return result;
}

}  // namespace holdfast
