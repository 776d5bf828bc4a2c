#include "baking/unwrap.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "baking/charts.hpp"
#include "baking/skyline_packer.hpp"
#include "holdfast/error.hpp"

namespace holdfast::baking {
namespace {

/// Charts lie on a grid of this many texels, so that the first mipmap levels mix no two charts.
constexpr int kGrid = 4;
/// The texture's sides are multiples of this, so that its mipmap levels halve evenly.
constexpr int kSides = 16;
/// Charts smaller than this join a neighbour, texels.
constexpr double kLeastExtent = 8;

/// A chart laid flat: metres, its lowest corner at the origin.
struct FlatChart {
  std::vector<std::uint32_t> triangles;
  std::vector<std::array<Eigen::Vector2d, 3>> corners;  // a triangle
  Eigen::Vector2d size;
};

/// Turned so that the smallest rectangle round it lies straight, its longer side level.
FlatChart flattened(const Mesh& mesh, const Chart& chart) {
  FlatChart flat;
  flat.triangles = chart.triangles;
  const ChartPlane plane(chart.axis);
  std::vector<cv::Point2f> points;
  // About the first corner and scaled, because the rectangle is found in single precision.
  const Eigen::Vector2d first = plane.project(mesh.positions[mesh.triangles[chart.triangles.front()][0]]);
  double largest = 0;
  for (const std::uint32_t t : chart.triangles) {
    std::array<Eigen::Vector2d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = plane.project(mesh.positions[mesh.triangles[t][k]]) - first;
      largest = std::max(largest, corners[k].cwiseAbs().maxCoeff());
    }
    flat.corners.push_back(corners);
  }
  for (const auto& corners : flat.corners) {
    for (const Eigen::Vector2d& corner : corners) {
      points.emplace_back(static_cast<float>(corner.x() / largest), static_cast<float>(corner.y() / largest));
    }
  }
  const cv::RotatedRect rectangle = cv::minAreaRect(points);
  double angle = rectangle.angle * M_PI / 180;
  if (rectangle.size.height > rectangle.size.width) {
    angle += M_PI / 2;
  }
  Eigen::Matrix2d turn;
  turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  Eigen::Vector2d low = turn * flat.corners[0][0];
  Eigen::Vector2d high = low;
  for (auto& corners : flat.corners) {
    for (Eigen::Vector2d& corner : corners) {
      corner = turn * corner;
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  for (auto& corners : flat.corners) {
    for (Eigen::Vector2d& corner : corners) {
      corner -= low;
    }
  }
  flat.size = high - low;
  return flat;
}

struct Atlas {
  int width = 0;
  int height = 0;
  std::vector<PackedPlace> places;  // a chart, texels, its padding's corner
};

int rounded_up(int value, int multiple) { return (value + multiple - 1) / multiple * multiple; }

PackedSize padded_size(const FlatChart& chart, double texels_per_metre, int padding) {
  const auto side = [&](double metres) {
    return rounded_up(static_cast<int>(std::ceil(metres * texels_per_metre)) + 1 + 2 * padding, kGrid);
  };
  return {side(chart.size.x()), side(chart.size.y())};
}

/// The nearly square atlas; larger than `largest_size` where it must be.
Atlas pack(const std::vector<FlatChart>& charts, double texels_per_metre, int padding) {
  std::vector<PackedSize> sizes;
  double area = 0;
  int widest = 0;
  for (const FlatChart& chart : charts) {
    sizes.push_back(padded_size(chart, texels_per_metre, padding));
    area += static_cast<double>(sizes.back().width) * sizes.back().height;
    widest = std::max(widest, sizes.back().width);
  }
  std::vector<std::size_t> order(charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::make_pair(sizes[a].height, sizes[a].width) > std::make_pair(sizes[b].height, sizes[b].width);
  });
  Atlas best;
  constexpr std::array<double, 6> stretches{1.0, 1.05, 1.1, 1.2, 1.35, 1.5};
  for (const double stretch : stretches) {
    const int width = rounded_up(std::max(widest, static_cast<int>(std::ceil(stretch * std::sqrt(area)))), kSides);
    SkylinePacker packer(width);
    Atlas atlas;
    atlas.width = width;
    atlas.places.resize(charts.size());
    for (const std::size_t i : order) {
      atlas.places[i] = packer.place(sizes[i]).value();
    }
    atlas.height = rounded_up(packer.height(), kSides);
    const auto cost = [](const Atlas& a) { return static_cast<double>(a.width) * a.height; };
    if (best.places.empty() || cost(atlas) < cost(best)) {
      best = std::move(atlas);
    }
  }
  return best;
}

void validate(const UnwrapOptions& options) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::invalid_argument, "unwrapping: " + what); };
  if (!(options.texels_per_metre > 0) || !std::isfinite(options.texels_per_metre)) {
    refuse("texels per metre must be positive");
  }
  if (options.padding < 1 || options.padding > 64) {
    refuse("the padding must be 1 to 64 texels");
  }
  if (options.largest_size < 64) {
    refuse("the largest texture must have at least 64 texels a side");
  }
  if (!(options.cone > 0) || options.cone > 1.2) {
    refuse("the cone must be above 0 and at most 1.2 radians");
  }
}

}  // namespace

Unwrapped unwrap(const Mesh& mesh, const UnwrapOptions& options) {
  validate(options);
  const MeshTopology topology = topology_of(mesh);
  const double least_extent = kLeastExtent / options.texels_per_metre;
  std::vector<FlatChart> charts;
  for (const Chart& chart : make_charts(mesh, topology, options.cone, least_extent)) {
    charts.push_back(flattened(mesh, chart));
  }
  if (charts.empty()) {
    throw Error(ErrorCode::model, "the model has no triangle with an area: there is no surface to bake a texture on");
  }

  double density = options.texels_per_metre;
  Atlas atlas = pack(charts, density, options.padding);
  while (std::max(atlas.width, atlas.height) > options.largest_size) {
    const double excess = static_cast<double>(std::max(atlas.width, atlas.height)) / options.largest_size;
    density /= std::max(1.02, 0.9 * excess);
    if (density < 1e-3 * options.texels_per_metre) {
      throw Error(ErrorCode::model, "the model falls into " + std::to_string(charts.size()) +
                                        " charts, which do not fit a texture of " +
                                        std::to_string(options.largest_size) +
                                        " texels a side; smooth or simplify the mesh, or give it texture coordinates");
    }
    atlas = pack(charts, density, options.padding);
  }

  Unwrapped result;
  result.width = atlas.width;
  result.height = atlas.height;
  result.charts = static_cast<int>(charts.size());
  result.texels_per_metre = density;
  result.mesh.materials.push_back({"baked", {}});
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const FlatChart& chart = charts[c];
    // The first texel's centre lies at half: there the chart begins, inside its padding.
    const Eigen::Vector2d origin(atlas.places[c].x + options.padding + 0.5, atlas.places[c].y + options.padding + 0.5);
    std::map<std::uint32_t, std::uint32_t> copies;
    for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
      std::array<std::uint32_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t original = mesh.triangles[chart.triangles[i]][k];
        const auto [copy, is_new] =
            copies.try_emplace(original, static_cast<std::uint32_t>(result.mesh.positions.size()));
        if (is_new) {
          const Eigen::Vector2d texel = origin + density * chart.corners[i][k];
          result.mesh.positions.push_back(mesh.positions[original]);
          result.mesh.texture_coordinates.emplace_back(static_cast<float>(texel.x() / atlas.width),
                                                       static_cast<float>(1 - texel.y() / atlas.height));
        }
        triangle[k] = copy->second;
      }
      result.mesh.triangles.push_back(triangle);
    }
  }
  return result;
}

}  // namespace holdfast::baking
