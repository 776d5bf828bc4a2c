#include "render/mip_levels.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace holdfast {
namespace {

/// The texels that one of the next level is a weighted mean of.
struct Taps {
  std::array<int, 3> texels{};
  std::array<std::uint64_t, 3> weights{};
  std::size_t count = 0;
};

std::vector<Taps> taps(int size, int half_size) {
  std::vector<Taps> result(static_cast<std::size_t>(half_size));
  for (int i = 0; i < half_size; ++i) {
    // In units of 1/half_size of a source texel, texel i of the next level spans [i size, (i + 1) size).
    const std::int64_t begin = std::int64_t{i} * size, end = begin + size;
    Taps& tap = result[static_cast<std::size_t>(i)];
    for (std::int64_t texel = begin / half_size; texel * half_size < end; ++texel) {
      tap.texels[tap.count] = static_cast<int>(texel);
      tap.weights[tap.count++] =
          static_cast<std::uint64_t>(std::min(end, (texel + 1) * half_size) - std::max(begin, texel * half_size));
    }
  }
  return result;
}

std::uint8_t rounded_ratio(std::uint64_t sum, std::uint64_t weight) {
  return static_cast<std::uint8_t>((sum + weight / 2) / weight);
}

/// The mean of two by two texels that were all seen, as most are: as of others, without divisions.
bool seen_mean(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out) {
  if ((upper[3] & upper[7] & lower[3] & lower[7]) != 255) return false;
  for (int channel = 0; channel < 3; ++channel) {
    out[channel] =
        static_cast<std::uint8_t>((upper[channel] + upper[channel + 4] + lower[channel] + lower[channel + 4] + 2) / 4);
  }
  out[3] = 255;
  return true;
}

Texture halved(const Texture& source) {
  Texture half{std::max(1, source.width / 2), std::max(1, source.height / 2), {}};
  half.rgba.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height) * 4);
  const std::vector<Taps> columns = taps(source.width, half.width), rows = taps(source.height, half.height);
  const bool even = source.width == 2 * half.width && source.height == 2 * half.height;
  const std::size_t stride = static_cast<std::size_t>(source.width) * 4;
  std::uint8_t* out = half.rgba.data();
  for (const Taps& row : rows) {
    const std::uint8_t* first_row = source.rgba.data() + static_cast<std::size_t>(row.texels[0]) * stride;
    for (const Taps& column : columns) {
      const std::uint8_t* upper = first_row + static_cast<std::size_t>(column.texels[0]) * 4;
      if (even && seen_mean(upper, upper + stride, out)) {
        out += 4;
        continue;
      }
      std::uint64_t area = 0;
      std::uint64_t seen = 0;
      std::array<std::uint64_t, 3> color{};
      std::array<std::uint64_t, 3> seen_color{};
      for (std::size_t j = 0; j < row.count; ++j) {
        const std::uint8_t* texel = upper + j * stride;
        for (std::size_t i = 0; i < column.count; ++i, texel += 4) {
          const std::uint64_t weight = row.weights[j] * column.weights[i];
          const std::uint64_t seen_weight = weight * texel[3];
          area += weight;
          seen += seen_weight;
          for (int channel = 0; channel < 3; ++channel) {
            color[channel] += weight * texel[channel];
            seen_color[channel] += seen_weight * texel[channel];
          }
        }
      }
      for (int channel = 0; channel < 3; ++channel) {
        out[channel] = seen > 0 ? rounded_ratio(seen_color[channel], seen) : rounded_ratio(color[channel], area);
      }
      out[3] = rounded_ratio(seen, area);
      out += 4;
    }
  }
  return half;
}

}  // namespace

std::vector<Texture> texture_levels(const Texture& base) {
  std::vector<Texture> levels;
  const Texture* last = &base;
  while (last->width > 1 || last->height > 1) {
    levels.push_back(halved(*last));
    last = &levels.back();
  }
  return levels;
}

}  // namespace holdfast
