#include "io/texture_wrap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "holdfast/error.hpp"

namespace holdfast::io {
namespace {

constexpr double kMostTexels = 64e6;
constexpr double kRounding = 1e-3;  // of coordinates, widths of the texture

/// Whole widths of the texture along one axis: the first that is drawn and how many.
struct Span {
  double first = 0;
  double count = 1;
};

Span span_of(Wrap wrap, int axis, const std::vector<Eigen::Vector2f*>& coordinates) {
  if (wrap == Wrap::repeat) return {};
  double least = 0, most = 1;
  for (const Eigen::Vector2f* coordinate : coordinates) {
    const double value = (*coordinate)[axis];
    if (!std::isfinite(value)) continue;  // said when the mesh is checked
    least = std::min(least, value);
    most = std::max(most, value);
  }
  const double first = std::floor(least + kRounding), end = std::ceil(most - kRounding);
  if (first == 0 && end == 1) return {};  // only its outermost half texel differs
  return wrap == Wrap::mirror ? Span{0, 2} : Span{first, end - first};
}

/// The texel of the texture that is seen at a place counted in texels from its begin.
int source(Wrap wrap, long place, int size) {
  if (wrap == Wrap::clamp) return static_cast<int>(std::clamp<long>(place, 0, size - 1));
  const long period = wrap == Wrap::mirror ? 2L * size : size;
  const long within = ((place % period) + period) % period;
  return static_cast<int>(within < size ? within : period - 1 - within);
}

}  // namespace

void wrap_texture(Material& material, const Wrapping& wrapping, const std::vector<Eigen::Vector2f*>& coordinates) {
  const Span u = span_of(wrapping.u, 0, coordinates), v = span_of(wrapping.v, 1, coordinates);
  const Texture& given = material.texture;
  if (u.count == 1 && u.first == 0 && v.count == 1 && v.first == 0) {
    return;
  }
  if (!(u.count * given.width * v.count * given.height <= kMostTexels)) {
    throw Error(ErrorCode::model,
                fmt::format("the texture of material '{}' is laid out over {:.0f} x {:.0f} times its size with clamped "
                            "or mirrored borders, which is not supported: repeat it, or scale the coordinates",
                            material.name, u.count, v.count));
  }
  Texture drawn{static_cast<int>(u.count) * given.width, static_cast<int>(v.count) * given.height, {}};
  drawn.rgba.resize(static_cast<std::size_t>(drawn.width) * static_cast<std::size_t>(drawn.height) * 4);
  const long left = std::lround(u.first) * given.width, bottom = std::lround(v.first) * given.height;
  std::size_t at = 0;
  for (int row = 0; row < drawn.height; ++row) {
    // Rows go down, v up.
    const int from = given.height - 1 - source(wrapping.v, bottom + drawn.height - 1 - row, given.height);
    for (int column = 0; column < drawn.width; ++column) {
      const int texel = source(wrapping.u, left + column, given.width);
      const std::size_t place = 4 * (static_cast<std::size_t>(from) * static_cast<std::size_t>(given.width) +
                                     static_cast<std::size_t>(texel));
      std::copy_n(given.rgba.begin() + static_cast<std::ptrdiff_t>(place), 4,
                  drawn.rgba.begin() + static_cast<std::ptrdiff_t>(at));
      at += 4;
    }
  }
  material.texture = std::move(drawn);
  for (Eigen::Vector2f* coordinate : coordinates) {
    coordinate->x() = static_cast<float>((coordinate->x() - u.first) / u.count);
    coordinate->y() = static_cast<float>((coordinate->y() - v.first) / v.count);
  }
}

}  // namespace holdfast::io
