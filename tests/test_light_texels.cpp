// Texels averaged as the light that they stand for: against sums in double precision, as the renderer draws them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/light_encoding.hpp"
#include "holdfast/error.hpp"
#include "render/enlarged_texture.hpp"
#include "render/mip_levels.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;
using test::random_texture;

/// IEC 61966-2-1, 0 to 1.
double light_of(double grey) {
  const double v = grey / 255;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double grey_of(double light) {
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

Texture with_alpha(Texture texture) {
  for (std::size_t i = 3; i < texture.rgba.size(); i += 4) texture.rgba[i] = (i / 4) % 3 == 0 ? 0 : 255;
  return texture;
}

/// Light (or alpha) of the texel that holds this place, in texels; beyond a border the nearest, or the opposite one.
struct Texels {
  const Texture& texture;
  bool repeat;

  const std::uint8_t* at(int x, int y) const {
    const auto inside = [this](int i, int size) {
      return repeat ? ((i % size) + size) % size : std::clamp(i, 0, size - 1);
    };
    return texture.rgba.data() + 4 * (inside(y, texture.height) * texture.width + inside(x, texture.width));
  }
};

/// What an interval [begin, begin + step) blurred by 1 2 1 weighs at a texel: by walking over it in small steps.
double weight(double begin, double step, int texel) {
  constexpr int kSteps = 1200;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const int there = static_cast<int>(std::floor(begin + step * (i + 0.5) / kSteps));
    const int off = std::abs(there - texel);
    sum += off == 0 ? 0.5 : off == 1 ? 0.25 : 0;
  }
  return sum / kSteps;
}

}  // namespace

TEST_CASE("encoded values and light follow the sRGB curve, and come back as they were") {
  const LightEncoding encoding;
  for (int value = 0; value < 256; ++value) {
    const std::uint16_t light = encoding.light(static_cast<std::uint8_t>(value));
    CHECK(light == doctest::Approx(65535 * light_of(value)).epsilon(0.0001).scale(5000));
    CHECK(encoding.encoded(light) == value);
  }
  double largest = 0;
  for (int light = 0; light < 65536; ++light) {
    largest =
        std::max(largest, std::abs(encoding.encoded(static_cast<std::uint16_t>(light)) - grey_of(light / 65535.0)));
  }
  CHECK(largest < 0.51);
}

TEST_CASE("each level averages the light of the one before, 1 3 3 1, seen texels alone") {
  const LightEncoding encoding;
  for (const auto& [width, height] : std::vector<std::pair<int, int>>{{8, 8}, {13, 7}, {6, 1}, {5, 4}, {3, 2}}) {
    for (const bool repeat : {false, true}) {
      for (const bool opaque : {true, false}) {
        const Texture random = random_texture(width, height, 7);
        const Texture base = opaque ? random : with_alpha(random);
        const Texture* above = &base;
        const std::vector<Texture> levels = light_levels(base, repeat, encoding);
        double color_error = 0, alpha_error = 0;
        for (const Texture& level : levels) {
          REQUIRE(level.width == std::max(1, above->width / 2));
          REQUIRE(level.height == std::max(1, above->height / 2));
          const double step_x = static_cast<double>(above->width) / level.width;
          const double step_y = static_cast<double>(above->height) / level.height;
          const Texels texels{*above, repeat};
          for (int y = 0; y < level.height; ++y) {
            for (int x = 0; x < level.width; ++x) {
              double seen = 0;
              std::array<double, 3> light{};
              for (int j = static_cast<int>(y * step_y) - 1; j <= static_cast<int>((y + 1) * step_y) + 1; ++j) {
                for (int i = static_cast<int>(x * step_x) - 1; i <= static_cast<int>((x + 1) * step_x) + 1; ++i) {
                  const std::uint8_t* texel = texels.at(i, j);
                  const double w = weight(x * step_x, step_x, i) * weight(y * step_y, step_y, j) * texel[3] / 255;
                  seen += w;
                  for (std::size_t c = 0; c < 3; ++c) light[c] += w * light_of(texel[c]);
                }
              }
              const std::uint8_t* texel = level.rgba.data() + 4 * (y * level.width + x);
              alpha_error = std::max(alpha_error, std::abs(texel[3] - 255 * seen));
              for (std::size_t c = 0; c < 3 && seen > 0.05; ++c) {
                color_error = std::max(color_error, std::abs(texel[c] - grey_of(light[c] / seen)));
              }
            }
          }
          above = &level;
        }
        CAPTURE(width);
        CAPTURE(height);
        CHECK(above->width * above->height == 1);
        // Half a level of rounding, and what never-seen texels weigh.
        CHECK(color_error < (opaque ? 0.55 : 0.8));
        CHECK(alpha_error < 0.55);
      }
    }
  }
}

TEST_CASE("an enlarged texture holds the light between its texels") {
  const LightEncoding encoding;
  const Texture base = with_alpha(random_texture(7, 5, 3));
  for (const int times : {2, 4}) {
    for (const bool repeat : {false, true}) {
      const Texture large = enlarged(base, times, repeat, encoding);
      REQUIRE(large.width == 7 * times);
      REQUIRE(large.height == 5 * times);
      const Texels texels{base, repeat};
      double error = 0;
      for (int y = 0; y < large.height; ++y) {
        for (int x = 0; x < large.width; ++x) {
          const double u = (x + 0.5) / times - 0.5, v = (y + 0.5) / times - 0.5;
          const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
          for (std::size_t c = 0; c < 4; ++c) {
            const auto value = [&](int di, int dj) {
              const double texel = texels.at(i + di, j + dj)[c];
              return c < 3 ? light_of(texel) : texel / 255;
            };
            const double s = u - i, t = v - j;
            const double mean =
                (1 - t) * ((1 - s) * value(0, 0) + s * value(1, 0)) + t * ((1 - s) * value(0, 1) + s * value(1, 1));
            const double wanted = c < 3 ? grey_of(mean) : 255 * mean;
            error =
                std::max(error, std::abs(large.rgba[static_cast<std::size_t>(4 * (y * large.width + x)) + c] - wanted));
          }
        }
      }
      CHECK(error < 0.55);
    }
  }
}

TEST_CASE("textures are enlarged as far as their texels are long on the surface and memory allows") {
  // 0.2 m square with the whole texture: 25 of it a square metre, 10 texels of 20 mm.
  const Mesh square = test::quad(random_texture(10, 10, 1));
  REQUIRE(texture_densities(square).size() == 1);
  CHECK(texture_densities(square)[0] == doctest::Approx(25).epsilon(1e-5));
  CHECK(texture_densities(test::quad(random_texture(10, 10, 1), 3))[0] == doctest::Approx(225).epsilon(1e-5));
  const Texture& texture = square.materials[0].texture;
  CHECK(enlargement(texture, 25, 0.021, 8192) == 1);
  CHECK(enlargement(texture, 25, 0.019, 8192) == 2);
  CHECK(enlargement(texture, 25, 0.009, 8192) == 4);
  CHECK(enlargement(texture, 25, 0.0001, 8192) == 4);
  CHECK(enlargement(texture, 25, 0.0001, 25) == 2);
  CHECK(enlargement(texture, 0, 0.0001, 8192) == 1);
  CHECK(enlargement(random_texture(2048, 1024, 1), 25, 0.00001, 8192) == 1);
  CHECK(enlargement(random_texture(1024, 1024, 1), 25, 0.00001, 8192) == 2);
}

TEST_CASE("half of light drawn small or between texels is not half of an encoded value") {
  Texture checks{64, 64, {}};
  for (int i = 0; i < 64 * 64; ++i) {
    const auto grey = static_cast<std::uint8_t>((i + i / 64) % 2 == 0 ? 0 : 255);
    for (const std::uint8_t value : {grey, grey, grey, std::uint8_t{255}}) checks.rgba.push_back(value);
  }
  Texture step{2, 1, {0, 0, 0, 255, 255, 255, 255, 255}};
  RendererOptions options;
  options.light_texels = true;
  const Camera camera{100, 100, 200, 200, 49.5, 49.5, {}};
  const auto middle = [&](const Texture& texture, double z, bool light) {
    Renderer renderer(test::quad(texture), camera.width, camera.height, options);
    renderer.set_light_texels(light);
    const test::View view = test::draw(renderer, test::pose_at({0, 0, z}), camera);
    // The mean of the two pixels round the middle, between which the step lies.
    return 0.5 * (view.pixel(49, 50)[1] + view.pixel(50, 50)[1]);
  };
  // 64 texels on 10 pixels.
  CHECK(middle(checks, 4, true) == doctest::Approx(grey_of(0.5)).epsilon(0.02));
  CHECK(middle(checks, 4, false) == doctest::Approx(127.5).epsilon(0.02));
  // 2 texels on 400 pixels.
  CHECK(middle(step, 0.1, true) == doctest::Approx(grey_of(0.5)).epsilon(0.02));
  CHECK(middle(step, 0.1, false) == doctest::Approx(127.5).epsilon(0.02));

  Renderer renderer(test::quad(step), camera.width, camera.height);
  CHECK_NOTHROW(renderer.set_light_texels(false));
  CHECK_THROWS_AS(renderer.set_light_texels(true), Error);
}
