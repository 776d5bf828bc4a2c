#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "baking/skyline_packer.hpp"
#include "baking/unwrap.hpp"
#include "holdfast/error.hpp"
#include "support/files.hpp"

using namespace holdfast;
using namespace holdfast::baking;
using holdfast::test::error_of;

namespace {

/// Two triangles a face, wound outwards, eight vertices.
Mesh box(const Eigen::Vector3f& size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(0.5F * Eigen::Vector3f((i & 1) != 0 ? size.x() : -size.x(),
                                                    (i & 2) != 0 ? size.y() : -size.y(),
                                                    (i & 4) != 0 ? size.z() : -size.z()));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A patch of a surface with `columns` x `rows` cells of two triangles; `at` gives its points for arguments in [0, 1].
template <class Surface>
Mesh patch(int columns, int rows, const Surface& at) {
  Mesh mesh;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      mesh.positions.push_back(
          at(static_cast<double>(i) / columns, static_cast<double>(j) / rows).template cast<float>());
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i);
      const auto below = static_cast<std::uint32_t>(a + columns + 1);
      mesh.triangles.push_back({a, a + 1, below + 1});
      mesh.triangles.push_back({a, below + 1, below});
    }
  }
  return mesh;
}

/// 20,000 triangles, closed but for a seam of repeated vertices.
Mesh torus() {
  return patch(125, 80, [](double s, double t) {
    const double a = 2 * std::numbers::pi * s;
    const double b = 2 * std::numbers::pi * t;
    const double r = 0.1 + 0.04 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.04 * std::sin(b));
  });
}

/// Triangles in texels, rows downwards.
using Flat = std::array<Eigen::Vector2d, 3>;

std::vector<Flat> flat_triangles(const Unwrapped& unwrapped) {
  std::vector<Flat> flat;
  for (const auto& triangle : unwrapped.mesh.triangles) {
    Flat corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d t = unwrapped.mesh.texture_coordinates[triangle[k]].cast<double>();
      corners[k] = {t.x() * unwrapped.width, (1 - t.y()) * unwrapped.height};
    }
    flat.push_back(corners);
  }
  return flat;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double area(const Flat& flat) { return 0.5 * std::abs(cross(flat[1] - flat[0], flat[2] - flat[0])); }

double area(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Eigen::Vector3d p = mesh.positions[a].cast<double>();
  return 0.5 * (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm();
}

/// Calls visit(x, y, triangle) for every point of a grid of `finer` points a texel that lies inside a triangle by more
/// than `inside` texels.
template <class Visit>
void visit_points(const std::vector<Flat>& flat, int finer, double inside, const Visit& visit) {
  for (std::size_t t = 0; t < flat.size(); ++t) {
    Flat c = flat[t];
    if (cross(c[1] - c[0], c[2] - c[0]) < 0) {
      std::swap(c[1], c[2]);
    }
    const Eigen::Vector2d low = c[0].cwiseMin(c[1]).cwiseMin(c[2]);
    const Eigen::Vector2d high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
    for (int y = static_cast<int>(std::floor(low.y() * finer)); y <= std::ceil(high.y() * finer); ++y) {
      for (int x = static_cast<int>(std::floor(low.x() * finer)); x <= std::ceil(high.x() * finer); ++x) {
        const Eigen::Vector2d p((x + 0.5) / finer, (y + 0.5) / finer);
        bool is_inside = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const Eigen::Vector2d edge = c[(k + 1) % 3] - c[k];
          is_inside = is_inside && cross(edge, p - c[k]) > inside * edge.norm();
        }
        if (is_inside) {
          visit(x, y, t);
        }
      }
    }
  }
}

/// Points of the texture, eight a texel and direction, that lie in more than one triangle.
long shared_points(const Unwrapped& unwrapped) {
  constexpr int finer = 8;
  const int columns = unwrapped.width * finer;
  std::vector<std::uint8_t> count(static_cast<std::size_t>(columns) * unwrapped.height * finer, 0);
  long shared = 0;
  visit_points(flat_triangles(unwrapped), finer, 2e-3, [&](int x, int y, std::size_t) {
    shared += count.at(static_cast<std::size_t>(y) * columns + x)++ == 1 ? 1 : 0;
  });
  return shared;
}

/// For each triangle a number that those share which hang together by common vertices.
std::vector<std::size_t> components(const Mesh& mesh) {
  std::vector<std::size_t> parent(mesh.positions.size());
  for (std::size_t i = 0; i < parent.size(); ++i) {
    parent[i] = i;
  }
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) {
      i = parent[i] = parent[parent[i]];
    }
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    parent[root(b)] = root(a);
    parent[root(c)] = root(a);
  }
  std::vector<std::size_t> result;
  for (const auto& triangle : mesh.triangles) {
    result.push_back(root(triangle[0]));
  }
  return result;
}

std::size_t component_count(const Mesh& mesh) {
  std::vector<std::size_t> all = components(mesh);
  std::sort(all.begin(), all.end());
  return static_cast<std::size_t>(std::unique(all.begin(), all.end()) - all.begin());
}

/// Smallest distance in columns or rows (the larger of both) between texels of different charts; `far` where none is
/// nearer.
int chart_distance(const Unwrapped& unwrapped, int far) {
  const std::vector<std::size_t> chart = components(unwrapped.mesh);
  std::vector<long> owner(static_cast<std::size_t>(unwrapped.width) * unwrapped.height, -1);
  visit_points(flat_triangles(unwrapped), 1, -1e-6, [&](int x, int y, std::size_t t) {
    owner.at(static_cast<std::size_t>(y) * unwrapped.width + x) = static_cast<long>(chart[t]);
  });
  const auto at = [&](int x, int y) { return owner[static_cast<std::size_t>(y) * unwrapped.width + x]; };
  int nearest = far;
  for (int y = 0; y < unwrapped.height; ++y) {
    for (int x = 0; x < unwrapped.width; ++x) {
      for (int dy = 0; dy < far && at(x, y) >= 0; ++dy) {
        for (int dx = -far + 1; dx < far; ++dx) {
          if (x + dx >= 0 && x + dx < unwrapped.width && y + dy < unwrapped.height && at(x + dx, y + dy) >= 0 &&
              at(x + dx, y + dy) != at(x, y)) {
            nearest = std::min(nearest, std::max(std::abs(dx), dy));
          }
        }
      }
    }
  }
  return nearest;
}

/// What holds for every unwrapped mesh.
void check_unwrapped(const Unwrapped& unwrapped) {
  CHECK_NOTHROW(unwrapped.mesh.validate());
  CHECK(unwrapped.mesh.materials.size() == 1);
  CHECK(shared_points(unwrapped) == 0);
  std::size_t outside = 0;
  for (const Eigen::Vector2f& t : unwrapped.mesh.texture_coordinates) {
    outside += t.minCoeff() < 0 || t.maxCoeff() > 1 ? 1 : 0;
  }
  CHECK(outside == 0);
  std::size_t mirrored = 0;
  for (const auto& [a, b, c] : unwrapped.mesh.triangles) {
    const auto& t = unwrapped.mesh.texture_coordinates;
    mirrored += cross((t[b] - t[a]).cast<double>(), (t[c] - t[a]).cast<double>()) > 0 ? 0 : 1;
  }
  CHECK(mirrored == 0);
}

/// Area in texels over surface area at the density, over the triangles: least, largest and mean weighted by area.
struct Scale {
  double least = 1e9;
  double largest = 0;
  double mean = 0;
};

Scale scale_of(const Unwrapped& unwrapped) {
  const std::vector<Flat> flat = flat_triangles(unwrapped);
  Scale scale;
  double surface = 0;
  double texels = 0;
  for (std::size_t t = 0; t < flat.size(); ++t) {
    const double wanted = area(unwrapped.mesh, t) * unwrapped.texels_per_metre * unwrapped.texels_per_metre;
    scale.least = std::min(scale.least, area(flat[t]) / wanted);
    scale.largest = std::max(scale.largest, area(flat[t]) / wanted);
    surface += wanted;
    texels += area(flat[t]);
  }
  scale.mean = texels / surface;
  return scale;
}

double surface_of(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sum += area(mesh, t);
  }
  return sum;
}

}  // namespace

TEST_CASE("A box becomes six charts at the surface's scale, apart by their padding") {
  UnwrapOptions options;
  options.texels_per_metre = 900;
  for (const int padding : {1, 4, 7}) {
    CAPTURE(padding);
    options.padding = padding;
    const Unwrapped unwrapped = unwrap(box({0.189F, 0.258F, 0.075F}), options);
    check_unwrapped(unwrapped);
    CHECK(unwrapped.charts == 6);
    CHECK(component_count(unwrapped.mesh) == 6);
    CHECK(unwrapped.mesh.triangles.size() == 12);
    CHECK(unwrapped.texels_per_metre == 900);
    const Scale scale = scale_of(unwrapped);
    CHECK(scale.least > 0.999);
    CHECK(scale.largest < 1.001);
    // Each chart has its padding to itself.
    CHECK(chart_distance(unwrapped, 40) > 2 * padding);
    // Not much of the texture is wasted.
    const double used = scale.mean * surface_of(unwrapped.mesh) * 900 * 900;
    CHECK(used > 0.55 * unwrapped.width * unwrapped.height);
  }
}

TEST_CASE("Vertices at one place count as one: a soup of triangles makes the same six charts") {
  const Mesh solid = box({0.1F, 0.2F, 0.3F});
  Mesh soup;
  for (const auto& triangle : solid.triangles) {
    for (const std::uint32_t vertex : triangle) {
      soup.positions.push_back(solid.positions[vertex]);
    }
    const auto first = static_cast<std::uint32_t>(soup.positions.size() - 3);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const Unwrapped unwrapped = unwrap(soup);
  check_unwrapped(unwrapped);
  CHECK(unwrapped.charts == 6);
}

TEST_CASE("A curved mesh of 20,000 triangles: few charts, little distortion, no overlap") {
  const Mesh mesh = torus();
  REQUIRE(mesh.triangles.size() == 20000);
  UnwrapOptions options;
  options.texels_per_metre = 1500;
  const Unwrapped unwrapped = unwrap(mesh, options);
  check_unwrapped(unwrapped);
  CHECK(unwrapped.mesh.triangles.size() == 20000);
  CHECK(unwrapped.charts >= 8);  // each covers less than a half turn both ways
  CHECK(unwrapped.charts <= 150);
  CHECK(chart_distance(unwrapped, 12) > 2 * options.padding);
  const Scale scale = scale_of(unwrapped);
  CHECK(scale.least > 0.4);
  CHECK(scale.largest < 1.001);
  CHECK(scale.mean > 0.9);
}

TEST_CASE("A winding staircase, seen from above on top of itself, is laid out side by side") {
  const Mesh mesh = patch(180, 4, [](double s, double t) {
    const double angle = 6 * std::numbers::pi * s;
    const double r = 0.1 - 0.05 * t;
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0.01 * angle);
  });
  const Unwrapped unwrapped = unwrap(mesh);
  check_unwrapped(unwrapped);
  CHECK(unwrapped.mesh.triangles.size() == mesh.triangles.size());
  CHECK(unwrapped.charts >= 3);
  CHECK(unwrapped.charts <= 12);
}

TEST_CASE("A rough surface does not fall into crumbs") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> height(-0.0008, 0.0008);
  const Mesh mesh =
      patch(60, 60, [&](double s, double t) { return Eigen::Vector3d(0.12 * s, 0.12 * t, height(random)); });
  const Unwrapped unwrapped = unwrap(mesh);
  check_unwrapped(unwrapped);
  CHECK(unwrapped.mesh.triangles.size() == mesh.triangles.size());
  CHECK(unwrapped.charts < 40);
}

TEST_CASE("Triangles without area are left out; a mesh of nothing else is refused") {
  Mesh mesh = box({0.1F, 0.1F, 0.1F});
  mesh.triangles.push_back({0, 1, 1});
  CHECK(unwrap(mesh).mesh.triangles.size() == 12);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  CHECK(error_of([&] { unwrap(line); }).says(ErrorCode::model, {"no triangle with an area"}));
}

TEST_CASE("A surface that does not fit gets fewer texels a metre") {
  UnwrapOptions options;
  options.texels_per_metre = 5000;
  options.largest_size = 256;
  const Unwrapped unwrapped = unwrap(box({0.2F, 0.2F, 0.2F}), options);
  check_unwrapped(unwrapped);
  CHECK(std::max(unwrapped.width, unwrapped.height) <= 256);
  CHECK(std::max(unwrapped.width, unwrapped.height) >= 200);
  CHECK(unwrapped.texels_per_metre < 500);
  CHECK(scale_of(unwrapped).mean == doctest::Approx(1).epsilon(0.001));
}

TEST_CASE("Options out of range are refused by name") {
  const Mesh mesh = box({0.1F, 0.1F, 0.1F});
  UnwrapOptions options;
  options.texels_per_metre = 0;
  CHECK(error_of([&] { unwrap(mesh, options); }).says(ErrorCode::invalid_argument, {"texels per metre"}));
  options = {};
  options.padding = 0;
  CHECK(error_of([&] { unwrap(mesh, options); }).says(ErrorCode::invalid_argument, {"padding"}));
  options = {};
  options.cone = 1.5;
  CHECK(error_of([&] { unwrap(mesh, options); }).says(ErrorCode::invalid_argument, {"cone"}));
}

TEST_CASE("Packed rectangles lie within the strip and apart") {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> side(1, 60);
  constexpr int width = 200;
  SkylinePacker packer(width);
  std::vector<std::array<int, 4>> placed;
  long area_sum = 0;
  for (int i = 0; i < 300; ++i) {
    const PackedSize size{side(random), side(random)};
    const auto place = packer.place(size);
    REQUIRE(place);
    CHECK(place->x >= 0);
    CHECK(place->y >= 0);
    CHECK(place->x + size.width <= width);
    CHECK(place->y + size.height <= packer.height());
    for (const auto& [x, y, w, h] : placed) {
      CHECK((x + w <= place->x || place->x + size.width <= x || y + h <= place->y || place->y + size.height <= y));
    }
    placed.push_back({place->x, place->y, size.width, size.height});
    area_sum += static_cast<long>(size.width) * size.height;
  }
  CHECK(area_sum > 0.6 * width * packer.height());
  CHECK_FALSE(packer.place({width + 1, 1}));
}
