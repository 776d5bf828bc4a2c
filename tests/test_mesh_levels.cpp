// Meshes drawn with fewer triangles: what is drawn stays where it was, measured by rays in double precision, and no gap
// opens.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "base/closed_surface.hpp"
#include "holdfast/error.hpp"
#include "holdfast/renderer.hpp"
#include "render/mesh_levels.hpp"

namespace {

using namespace holdfast;

/// Metres of the surface to a texture coordinate of one, of the bodies below.
constexpr double kTextureMetres = 0.4;

Texture checks() {
  Texture texture;
  texture.width = texture.height = 64;
  texture.rgba.assign(64 * 64 * 4, 255);
  for (std::size_t i = 0; i < 64 * 64; ++i) {
    if ((i / 8 + i / 512) % 2 == 0) texture.rgba[4 * i] = texture.rgba[4 * i + 1] = 40;
  }
  return texture;
}

/// A bumpy closed body of `columns` x `rows` quads with one texture seam and two caps; optionally the upper half of
/// another material.
Mesh body(int columns, int rows, bool two_materials = false) {
  Mesh mesh;
  for (int j = 1; j < rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double around = 2 * std::numbers::pi * (i % columns) / columns, up = std::numbers::pi * j / rows;
      const double radius = 0.06 * (1 + 0.1 * std::sin(3 * around) * std::sin(2 * up));
      mesh.positions.emplace_back(Eigen::Vector3d(radius * std::sin(up) * std::cos(around),
                                                  radius * std::sin(up) * std::sin(around), -radius * std::cos(up))
                                      .cast<float>());
      mesh.texture_coordinates.emplace_back(static_cast<float>(i) / static_cast<float>(columns),
                                            static_cast<float>(j) / static_cast<float>(rows));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>((j - 1) * (columns + 1) + i); };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, int j) {
    mesh.triangles.push_back({a, b, c});
    if (two_materials) mesh.triangle_materials.push_back(j >= rows / 2 ? 1 : 0);
  };
  for (int j = 1; j + 1 < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      add(at(i, j), at(i + 1, j), at(i + 1, j + 1), j);
      add(at(i, j), at(i + 1, j + 1), at(i, j + 1), j);
    }
  }
  const auto south = static_cast<std::uint32_t>(mesh.positions.size()), north = south + 1;
  mesh.positions.emplace_back(0.0F, 0.0F, -0.06F);
  mesh.positions.emplace_back(0.0F, 0.0F, 0.06F);
  mesh.texture_coordinates.emplace_back(0.5F, 0.0F);
  mesh.texture_coordinates.emplace_back(0.5F, 1.0F);
  for (int i = 0; i < columns; ++i) {
    add(south, at(i + 1, 1), at(i, 1), 0);
    add(north, at(i, rows - 1), at(i + 1, rows - 1), rows);
  }
  mesh.materials.resize(two_materials ? 2 : 1);
  for (Material& material : mesh.materials) material.texture = checks();
  return mesh;
}

Mesh with(const Mesh& mesh, const MeshLevel& level) {
  Mesh coarse = mesh;
  coarse.positions.clear();
  for (const Eigen::Vector3d& p : level.positions) coarse.positions.push_back(p.cast<float>());
  coarse.texture_coordinates = level.texture_coordinates;
  coarse.triangles = level.triangles;
  coarse.triangle_materials = level.triangle_materials;
  return coarse;
}

struct Hit {
  double distance = 1e9;
  Eigen::Vector2d texture = Eigen::Vector2d::Zero();
};

Hit first_hit(const Mesh& mesh, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  Hit hit;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>();
    Eigen::Matrix3d M;
    M << mesh.positions[t[1]].cast<double>() - a, mesh.positions[t[2]].cast<double>() - a, -direction;
    if (std::abs(M.determinant()) < 1e-15) continue;
    const Eigen::Vector3d x = M.inverse() * (origin - a);
    if (x(0) < 0 || x(1) < 0 || x(0) + x(1) > 1 || x(2) < 0 || x(2) > hit.distance) continue;
    const auto uv = [&](std::uint32_t i) { return mesh.texture_coordinates[i].cast<double>().eval(); };
    hit = {x(2), uv(t[0]) + x(0) * (uv(t[1]) - uv(t[0])) + x(1) * (uv(t[2]) - uv(t[0]))};
  }
  return hit;
}

using Place = std::array<float, 5>;

/// Edges (pairs of places on surface and texture) that one triangle only passes, and those between two materials.
std::set<std::pair<Place, Place>> borders(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}].push_back(mesh.triangle_materials.empty() ? 0
                                                                                        : mesh.triangle_materials[i]);
    }
  }
  const auto place = [&](std::uint32_t vertex) {
    const Eigen::Vector3f& p = mesh.positions[vertex];
    const Eigen::Vector2f& t = mesh.texture_coordinates[vertex];
    return Place{p.x(), p.y(), p.z(), t.x(), t.y()};
  };
  std::set<std::pair<Place, Place>> found;
  for (const auto& [edge, materials] : edges) {
    if (materials.size() != 2 || materials[0] != materials[1]) {
      found.insert(std::minmax(place(edge.first), place(edge.second)));
    }
  }
  return found;
}

}  // namespace

TEST_CASE("levels have ever fewer triangles, lie where the mesh lies as far as they say, and carry its texture") {
  const Mesh mesh = body(72, 36);
  const auto levels = mesh_levels(mesh, MeshAspect::appearance);
  REQUIRE(levels.size() >= 3);
  double last = 0;
  std::size_t count = mesh.triangles.size();
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (const MeshLevel& level : levels) {
    CAPTURE(level.triangles.size());
    CHECK(level.triangles.size() <= 0.9 * static_cast<double>(count));
    CHECK(level.deviation >= last);
    CHECK(level.deviation <= 0.02 * mesh.radius());
    count = level.triangles.size();
    last = level.deviation;
    const Mesh coarse = with(mesh, level);
    double square = 0, largest = 0;
    constexpr int kRays = 400;
    for (int i = 0; i < kRays; ++i) {
      const Eigen::Vector3d direction = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      // Off the caps, where the texture is pinched.
      if (std::abs(direction.z()) > 0.9) continue;
      const Eigen::Vector3d origin = -0.3 * direction;
      const Hit fine = first_hit(mesh, origin, direction), drawn = first_hit(coarse, origin, direction);
      REQUIRE(drawn.distance < 1);  // no gap
      const double off =
          std::hypot(fine.distance - drawn.distance, 0.5 * kTextureMetres * (fine.texture - drawn.texture).norm());
      square += off * off;
      largest = std::max(largest, off);
    }
    INFO("deviation ", level.deviation, " m, measured ", std::sqrt(square / kRays), ", largest ", largest);
    CHECK(std::sqrt(square / kRays) < 1.5 * level.deviation);
    CHECK(largest < 6 * level.deviation);
  }
}

TEST_CASE("seams, borders of materials and closedness stay") {
  for (const bool two_materials : {false, true}) {
    const Mesh mesh = body(60, 30, two_materials);
    REQUIRE(is_closed_outward(mesh));
    const auto before = borders(mesh);
    REQUIRE(before.size() >= (two_materials ? 100U : 50U));
    const auto levels = mesh_levels(mesh, MeshAspect::appearance);
    REQUIRE(levels.size() >= 2);
    for (const MeshLevel& level : levels) {
      const Mesh coarse = with(mesh, level);
      CHECK(borders(coarse) == before);
      CHECK(is_closed_outward(coarse));
      CHECK(level.triangle_materials.size() == (two_materials ? level.triangles.size() : 0));
    }
  }
}

TEST_CASE("very many triangles are thinned out first, and lie where the mesh lies as far as that says") {
  const Mesh mesh = body(480, 240);
  REQUIRE(mesh.triangles.size() > 200000);
  const auto before = borders(mesh);
  for (const MeshAspect aspect : {MeshAspect::appearance, MeshAspect::shape}) {
    const bool looks = aspect == MeshAspect::appearance;
    const auto levels = mesh_levels(mesh, aspect);
    REQUIRE(levels.size() >= 5);
    CHECK(levels[0].triangles.size() <= 50000);
    CHECK(levels[0].triangles.size() >= 45000);
    CHECK(levels[0].deviation < 2e-3 * mesh.radius());
    Mesh coarse = with(mesh, levels[0]);
    if (looks) {
      CHECK(borders(coarse) == before);
    } else {
      coarse.materials.clear();
      coarse.texture_coordinates.assign(coarse.positions.size(), Eigen::Vector2f::Zero());
    }
    CHECK(is_closed_outward(coarse));
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, 1);
    double square = 0;
    constexpr int kRays = 25;
    for (int i = 0; i < kRays; ++i) {
      const Eigen::Vector3d direction = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      if (std::abs(direction.z()) > 0.9) continue;
      const Hit fine = first_hit(mesh, -0.3 * direction, direction),
                drawn = first_hit(coarse, -0.3 * direction, direction);
      REQUIRE(drawn.distance < 1);  // no gap
      const double slid = looks ? 0.5 * kTextureMetres * (fine.texture - drawn.texture).norm() : 0;
      square += std::pow(fine.distance - drawn.distance, 2) + slid * slid;
    }
    INFO("deviation ", levels[0].deviation, " m, measured ", std::sqrt(square / kRays));
    CHECK(std::sqrt(square / kRays) < 1.5 * levels[0].deviation);
  }
}

TEST_CASE("on a flat sheet only a texture that is bent has a price") {
  const auto sheet = [](double bend) {
    Mesh mesh;
    constexpr int kSide = 30;
    for (int j = 0; j <= kSide; ++j) {
      for (int i = 0; i <= kSide; ++i) {
        const double x = static_cast<double>(i) / kSide, y = static_cast<double>(j) / kSide;
        mesh.positions.emplace_back(static_cast<float>(0.2 * x), static_cast<float>(0.2 * y), 0.0F);
        mesh.texture_coordinates.emplace_back(static_cast<float>(x + bend * x * x),
                                              static_cast<float>(y + bend * y * y));
      }
    }
    for (std::uint32_t j = 0; j < kSide; ++j) {
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const std::uint32_t a = j * (kSide + 1) + i, b = a + kSide + 1;
        mesh.triangles.push_back({a, a + 1, b + 1});
        mesh.triangles.push_back({a, b + 1, b});
      }
    }
    mesh.materials.resize(1);
    mesh.materials[0].texture = checks();
    return mesh;
  };
  const auto flat = mesh_levels(sheet(0), MeshAspect::appearance),
             bent = mesh_levels(sheet(0.5), MeshAspect::appearance);
  REQUIRE(flat.size() >= 2);
  REQUIRE(bent.size() >= 2);
  CHECK(flat.back().deviation < 1e-6);  // rounding
  CHECK(bent[0].deviation > 1e-5);
  CHECK(bent[1].deviation > bent[0].deviation);
}

TEST_CASE("few triangles and vertex colours are left as they are; triangles without an area do no harm") {
  CHECK(mesh_levels(body(20, 10), MeshAspect::appearance).empty());
  Mesh colored = body(60, 30);
  colored.colors.assign(colored.positions.size(), {200, 100, 50, 255});
  CHECK(mesh_levels(colored, MeshAspect::appearance).empty());
  Mesh degenerate = body(60, 30);
  degenerate.triangles.push_back({0, 0, 5});
  degenerate.triangles.push_back({0, 1, 2});  // on one line but for the body's shape
  degenerate.positions.push_back(degenerate.positions[40]);
  degenerate.texture_coordinates.push_back(degenerate.texture_coordinates[40]);
  for (const MeshLevel& level : mesh_levels(degenerate, MeshAspect::appearance)) {
    CHECK(std::isfinite(level.deviation));
    for (const auto& triangle : level.triangles) {
      for (const std::uint32_t index : triangle) CHECK(index < level.positions.size());
    }
  }
}

TEST_CASE("levels of the shape alone know no seams and stay where the shape is") {
  const Mesh mesh = body(72, 36, true);
  const auto levels = mesh_levels(mesh, MeshAspect::shape), looks = mesh_levels(mesh, MeshAspect::appearance);
  REQUIRE(levels.size() >= 3);
  CHECK(levels.back().triangles.size() < looks.back().triangles.size() / 2);
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 1);
  for (const MeshLevel& level : levels) {
    CAPTURE(level.triangles.size());
    CHECK(level.texture_coordinates.empty());
    CHECK(level.triangle_materials.empty());
    Mesh coarse = with(mesh, level);
    coarse.materials.clear();
    CHECK(is_closed_outward(coarse));
    coarse.texture_coordinates.assign(coarse.positions.size(), Eigen::Vector2f::Zero());
    double square = 0, sum = 0;
    constexpr int kRays = 400;
    for (int i = 0; i < kRays; ++i) {
      const Eigen::Vector3d direction = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      const double off = first_hit(coarse, -0.3 * direction, direction).distance -
                         first_hit(mesh, -0.3 * direction, direction).distance;
      REQUIRE(std::abs(off) < 0.01);  // no gap
      square += off * off;
      sum += off;
    }
    INFO("deviation ", level.deviation, " m, measured ", std::sqrt(square / kRays), ", mean ", sum / kRays);
    CHECK(std::sqrt(square / kRays) < 1.5 * level.deviation);
    // It neither shrinks nor grows, as it would if vertices stayed on the surface.
    CHECK(std::abs(sum / kRays) < 0.3 * level.deviation);
  }
}

TEST_CASE("drawn with what a tenth of a pixel allows, a view is the same but for a tenth of a pixel") {
  const Mesh mesh = body(240, 120);
  const Camera camera{320, 240, 400, 400, 159.5, 119.5, {}};
  Renderer whole(mesh, 320, 240, {4, 0}), coarse(mesh, 320, 240, {4, 0.1, false, true});
  CHECK_THROWS_AS(Renderer(mesh, 320, 240, {4, -1.0}), Error);
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 0.3, 0.2).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.01, 0.02, 0.5);
  constexpr std::size_t kPixels = 320 * 240;
  std::vector<std::uint8_t> rgba_whole(4 * kPixels), rgba_coarse(4 * kPixels);
  std::vector<float> depth_whole(kPixels), depth_coarse(kPixels);
  const DepthRange range = whole.render(T, camera, {0, 0, 320, 240}, {rgba_whole.data(), depth_whole.data(), 0});
  coarse.render(T, camera, {0, 0, 320, 240}, {rgba_coarse.data(), depth_coarse.data(), 0});
  const auto metres = [&](float window) {
    return range.near_plane * range.far_plane /
           (range.far_plane - static_cast<double>(window) * (range.far_plane - range.near_plane));
  };
  struct Difference {
    int drawn = 0, missing = 0, added = 0;
    double rms = 0;
  };
  const auto difference = [&](const std::vector<float>& depth) {
    Difference d;
    double square = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const bool a = depth_whole[i] < 1.0F, b = depth[i] < 1.0F;
      d.missing += a && !b;
      d.added += b && !a;
      if (!a || !b) continue;
      ++d.drawn;
      const double off = metres(depth_whole[i]) - metres(depth[i]);
      // Near the silhouette depth is as steep as one likes.
      square += std::min(off * off, 1e-6);
    }
    d.rms = std::sqrt(square / d.drawn);
    return d;
  };
  std::vector<float> depth_alone(kPixels);
  coarse.render(T, camera, {0, 0, 320, 240}, {nullptr, depth_alone.data(), 0});
  CHECK(depth_alone != depth_coarse);  // another mesh than for colours
  // Silhouettes may be off by twice as much.
  for (const auto& [depth, tenths] : {std::pair{&depth_coarse, 1}, {&depth_alone, 2}}) {
    const Difference d = difference(*depth);
    REQUIRE(d.drawn > 5000);
    // A tenth of a pixel is 0.12 mm here; the silhouette is some 300 pixels long.
    CHECK(d.rms < tenths * 1.2e-4);
    CHECK(d.missing + d.added < tenths * 30);
    CHECK(std::abs(d.missing - d.added) < tenths * 10);
  }
  int differing = 0;
  for (std::size_t i = 0; i < kPixels; ++i) differing += rgba_whole[4 * i] != rgba_coarse[4 * i];
  CHECK(differing > 100);  // it was not the whole mesh that was drawn
}
