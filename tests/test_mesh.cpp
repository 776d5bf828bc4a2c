#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/one_color.hpp"
#include "holdfast/error.hpp"
#include "holdfast/mesh.hpp"
#include "render/mip_levels.hpp"

namespace holdfast {
namespace {

Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions = {{1, 1, 1}, {3, 1, 1}, {1, 5, 1}, {1, 1, 9}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  return mesh;
}

Texture random_texture(int width, int height, bool opaque) {
  std::mt19937 random(static_cast<unsigned>(width * 1000 + height));
  Texture texture{width, height, {}};
  texture.rgba.resize(static_cast<std::size_t>(width) * height * 4);
  for (std::size_t i = 0; i < texture.rgba.size(); ++i) {
    texture.rgba[i] = opaque && i % 4 == 3 ? std::uint8_t{255} : static_cast<std::uint8_t>(random());
  }
  return texture;
}

std::string error_of(const Mesh& mesh) {
  try {
    mesh.validate();
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::model);
    return error.what();
  }
  return "no error";
}

/// Integral over [begin, end) of the piecewise constant channel, weighted with the alpha when asked: the obvious loop.
struct Box {
  double seen = 0;
  double area = 0;
  double color = 0;
};

Box box_average(const Texture& texture, int channel, double x0, double x1, double y0, double y1) {
  Box box;
  for (int y = 0; y < texture.height; ++y) {
    for (int x = 0; x < texture.width; ++x) {
      const double overlap = std::max(0.0, std::min(x1, x + 1.0) - std::max(x0, double(x))) *
                             std::max(0.0, std::min(y1, y + 1.0) - std::max(y0, double(y)));
      const std::uint8_t* texel = texture.rgba.data() + (static_cast<std::size_t>(y) * texture.width + x) * 4;
      box.area += overlap;
      box.seen += overlap * texel[3] / 255;
      box.color += overlap * texel[3] / 255 * texel[channel];
    }
  }
  return box;
}

}  // namespace

TEST_CASE("one colour, as compression leaves it, is told from two, on vertices and in textures") {
  Mesh mesh = tetrahedron();
  CHECK(is_of_one_color(mesh));
  mesh.colors = {{90, 100, 110, 255}, {98, 100, 110, 255}, {94, 96, 110, 255}, {90, 100, 103, 255}};
  CHECK(is_of_one_color(mesh));
  mesh.colors[3][1] = 105;
  CHECK_FALSE(is_of_one_color(mesh));
  mesh.colors[3][3] = 249;  // not known
  CHECK(is_of_one_color(mesh));
  mesh.colors.clear();
  Material material;
  material.texture = {2, 1, {50, 60, 70, 255, 55, 60, 70, 255}};
  mesh.materials = {material};
  CHECK(is_of_one_color(mesh));
  material.texture.rgba[2] = 79;
  mesh.materials.push_back(material);
  CHECK_FALSE(is_of_one_color(mesh));
}

TEST_CASE("Centre and radius are of the bounding box") {
  const Mesh mesh = tetrahedron();
  CHECK(mesh.center() == Eigen::Vector3d(2, 3, 5));
  CHECK(mesh.radius() == doctest::Approx(std::sqrt(1.0 + 4.0 + 16.0)).epsilon(1e-15));
  CHECK(Mesh{}.center() == Eigen::Vector3d::Zero());
  CHECK(Mesh{}.radius() == 0);
}

TEST_CASE("Appearance is a texture in use with coordinates, or vertex colours") {
  Mesh mesh = tetrahedron();
  CHECK(!mesh.has_appearance());
  mesh.materials = {{"plain", {}}, {"textured", random_texture(2, 2, true)}};
  CHECK(!mesh.has_appearance());
  mesh.triangle_materials = {0, 0, 1, 0};
  CHECK(!mesh.has_appearance());
  mesh.texture_coordinates.resize(4);
  CHECK(mesh.has_appearance());
  mesh.triangle_materials = {0, 0, 0, 0};
  CHECK(!mesh.has_appearance());
  mesh.triangle_materials.clear();
  CHECK(!mesh.has_appearance());
  mesh.colors.resize(4);
  CHECK(mesh.has_appearance());
  mesh.triangles.clear();
  CHECK(!mesh.has_appearance());
}

TEST_CASE("A mesh that cannot be used is an error that says why") {
  CHECK(error_of(tetrahedron()) == "no error");
  const auto says = [](const auto& change, const std::string& text) {
    Mesh mesh = tetrahedron();
    change(mesh);
    const std::string message = error_of(mesh);
    CAPTURE(message);
    CHECK(message.find(text) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
  };
  says([](Mesh& mesh) { mesh.triangles.clear(); }, "no triangles");
  says([](Mesh& mesh) { mesh.positions[2].y() = std::numeric_limits<float>::quiet_NaN(); }, "vertex 2");
  says([](Mesh& mesh) { mesh.positions[1].x() = std::numeric_limits<float>::infinity(); }, "vertex 1");
  says([](Mesh& mesh) { mesh.triangles[3][1] = 4; }, "triangle 3 refers to vertex 4");
  says([](Mesh& mesh) { mesh.texture_coordinates.resize(3); }, "3 texture coordinates for 4");
  says(
      [](Mesh& mesh) {
        mesh.texture_coordinates.assign(4, Eigen::Vector2f::Zero());
        mesh.texture_coordinates[3].x() = std::numeric_limits<float>::quiet_NaN();
      },
      "vertex 3");
  says([](Mesh& mesh) { mesh.materials = {{"printed", random_texture(4, 4, true)}}; }, "no texture coordinates");
  says([](Mesh& mesh) { mesh.colors.resize(5); }, "5 vertex colours for 4");
  says([](Mesh& mesh) { mesh.triangle_materials.assign(3, 0); }, "3 material indices for 4");
  says([](Mesh& mesh) { mesh.triangle_materials = {0, 0, 1, 0}; }, "triangle 2 refers to material 1");
  says(
      [](Mesh& mesh) {
        mesh.materials = {{"cut", random_texture(4, 4, true)}};
        mesh.materials[0].texture.rgba.pop_back();
      },
      "4x4");
  says([](Mesh& mesh) { mesh.positions.assign(4, Eigen::Vector3f(1, 2, 3)); }, "no extent");
}

TEST_CASE("Each mip level is the seen-weighted box average of the level before") {
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{8, 8}, {16, 4}, {13, 7}, {1, 6}, {5, 1}, {3, 2}}) {
    for (const bool opaque : {true, false}) {
      const Texture base = random_texture(width, height, opaque);
      const std::vector<Texture> levels = texture_levels(base);
      const Texture* above = &base;
      for (const Texture& level : levels) {
        REQUIRE(level.width == std::max(1, above->width / 2));
        REQUIRE(level.height == std::max(1, above->height / 2));
        REQUIRE(level.rgba.size() == static_cast<std::size_t>(level.width) * level.height * 4);
        const double step_x = static_cast<double>(above->width) / level.width;
        const double step_y = static_cast<double>(above->height) / level.height;
        double error = 0;
        for (int y = 0; y < level.height; ++y) {
          for (int x = 0; x < level.width; ++x) {
            const std::uint8_t* texel = level.rgba.data() + (static_cast<std::size_t>(y) * level.width + x) * 4;
            for (int channel = 0; channel < 3; ++channel) {
              const Box box = box_average(*above, channel, x * step_x, (x + 1) * step_x, y * step_y, (y + 1) * step_y);
              error = std::max(error, std::abs(texel[channel] - box.color / box.seen));
              error = std::max(error, std::abs(texel[3] - 255 * box.seen / box.area));
            }
          }
        }
        CHECK(error <= 0.5 + 1e-9);
        above = &level;
      }
      CHECK(above->width == 1);
      CHECK(above->height == 1);
    }
  }
}

TEST_CASE("Where nothing was seen the mip levels say so") {
  Texture texture = random_texture(4, 4, true);
  for (std::size_t i = 3; i < texture.rgba.size(); i += 4) {
    texture.rgba[i] = 0;
  }
  for (const Texture& level : texture_levels(texture)) {
    for (std::size_t i = 3; i < level.rgba.size(); i += 4) {
      CHECK(level.rgba[i] == 0);
    }
  }
  CHECK(texture_levels(random_texture(1, 1, true)).empty());
}

}  // namespace holdfast
