#include "render/texture_levels.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace holdfast {
namespace {

// The source texels under one texel of the next level: two, or three where an odd size does not halve evenly.
struct Footprint {
  int first = 0;
  int count = 0;
  std::array<std::uint64_t, 3> weights{};
};

std::vector<Footprint> footprints(int size, int half_size) {
  std::vector<Footprint> result(half_size);
  for (int i = 0; i < half_size; ++i) {
    Footprint& footprint = result[i];
    if (size == 2 * half_size) {
      footprint = {2 * i, 2, {1, 1, 0}};
      continue;
    }
    // In units of 1/half_size of a source texel, texel i of the next level spans [i size, (i + 1) size).
    const std::int64_t begin = std::int64_t{i} * size;
    const std::int64_t end = begin + size;
    footprint.first = static_cast<int>(begin / half_size);
    for (std::int64_t texel = footprint.first; texel * half_size < end; ++texel) {
      const std::int64_t overlap = std::min(end, (texel + 1) * half_size) - std::max(begin, texel * half_size);
      footprint.weights[footprint.count++] = static_cast<std::uint64_t>(overlap);
    }
  }
  return result;
}

std::uint8_t rounded_ratio(std::uint64_t sum, std::uint64_t weight) {
  return static_cast<std::uint8_t>((sum + weight / 2) / weight);
}

/// What most texels of most textures are: the mean of two by two that were all seen. The same as what is done of
/// others, without its divisions.
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
  Texture half;
  half.width = std::max(1, source.width / 2);
  half.height = std::max(1, source.height / 2);
  half.rgba.resize(static_cast<std::size_t>(half.width) * half.height * 4);
  const std::vector<Footprint> columns = footprints(source.width, half.width);
  const std::vector<Footprint> rows = footprints(source.height, half.height);

  const bool even = source.width == 2 * half.width && source.height == 2 * half.height;
  const std::size_t stride = static_cast<std::size_t>(source.width) * 4;
  std::uint8_t* out = half.rgba.data();
  for (const Footprint& row : rows) {
    const std::uint8_t* first_row = source.rgba.data() + static_cast<std::size_t>(row.first) * stride;
    for (const Footprint& column : columns) {
      const std::uint8_t* upper = first_row + static_cast<std::size_t>(column.first) * 4;
      if (even && seen_mean(upper, upper + stride, out)) {
        out += 4;
        continue;
      }
      std::uint64_t area = 0;
      std::uint64_t seen = 0;
      std::array<std::uint64_t, 3> color{};
      std::array<std::uint64_t, 3> seen_color{};
      for (int j = 0; j < row.count; ++j) {
        const std::uint8_t* texel = upper + static_cast<std::size_t>(j) * stride;
        for (int i = 0; i < column.count; ++i, texel += 4) {
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
