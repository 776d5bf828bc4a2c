#include "render/mip_levels.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace holdfast {
namespace {

/// A texel never seen weighs so much beside one that was, in light: only where all are unseen its colour counts.
constexpr float kUnseen = 1e-4F;

/// The texels that one of the next level is a weighted mean of.
struct Taps {
  std::array<int, 5> texels{};
  std::array<std::uint64_t, 5> weights{};
  std::array<float, 5> shares{};  ///< the weights, where they are soft, over their sum
  std::size_t count = 0;
};

std::vector<Taps> taps(int size, int half_size, bool soft, bool repeat) {
  std::vector<Taps> result(static_cast<std::size_t>(half_size));
  for (int i = 0; i < half_size; ++i) {
    // In units of 1/half_size of a source texel, texel i of the next level spans [i size, (i + 1) size).
    const std::int64_t begin = std::int64_t{i} * size, end = begin + size;
    const auto overlap = [&](std::int64_t texel) {
      const std::int64_t first = std::max(begin, texel * half_size), last = std::min(end, (texel + 1) * half_size);
      return static_cast<std::uint64_t>(std::max(std::int64_t{0}, last - first));
    };
    const int around = soft ? 1 : 0;
    const int first = static_cast<int>(begin / half_size), last = static_cast<int>((end - 1) / half_size);
    Taps& tap = result[static_cast<std::size_t>(i)];
    for (int texel = first - around; texel <= last + around; ++texel) {
      // Softly: the texel's own area, blurred by 1 2 1.
      const std::uint64_t own = overlap(texel);
      const std::uint64_t weight = soft ? overlap(texel - 1) + 2 * own + overlap(texel + 1) : own;
      tap.texels[tap.count] = repeat ? (texel + size) % size : std::clamp(texel, 0, size - 1);
      tap.weights[tap.count] = weight;
      tap.shares[tap.count++] = static_cast<float>(static_cast<double>(weight) / (4.0 * size));
    }
  }
  return result;
}

Texture of_half_size(const Texture& source) {
  Texture half{std::max(1, source.width / 2), std::max(1, source.height / 2), {}};
  half.rgba.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height) * 4);
  return half;
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
  Texture half = of_half_size(source);
  const std::vector<Taps> columns = taps(source.width, half.width, false, false);
  const std::vector<Taps> rows = taps(source.height, half.height, false, false);
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

/// A row of light, weighted by alpha, and of what that weighs.
using Row = std::vector<Eigen::Array4f>;

Texture halved(const Texture& source, bool repeat, const LightEncoding& encoding) {
  Texture half = of_half_size(source);
  const std::vector<Taps> columns = taps(source.width, half.width, true, repeat);
  const std::vector<Taps> rows = taps(source.height, half.height, true, repeat);
  Row light(static_cast<std::size_t>(source.width));
  const auto along = [&](int row, Row& line) {
    const std::uint8_t* texel = source.rgba.data() + static_cast<std::size_t>(row) * light.size() * 4;
    for (Eigen::Array4f& lit : light) {
      const float weight = static_cast<float>(texel[3]) * (1.0F / 255) + kUnseen;
      // One by one, where they stay: put together first they would be waited for on their way through memory.
      for (int c = 0; c < 3; ++c) lit[c] = weight * static_cast<float>(encoding.light(texel[c]));
      lit[3] = weight;
      texel += 4;
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      Eigen::Array4f sum = Eigen::Array4f::Zero();
      for (std::size_t k = 0; k < columns[i].count; ++k) {
        sum += columns[i].shares[k] * light[static_cast<std::size_t>(columns[i].texels[k])];
      }
      line[i] = sum;
    }
  };
  // Neighbouring rows need nearly the same ones.
  struct Held {
    int row = -1;
    Row line;
  };
  std::array<Held, 8> held;
  for (Held& one : held) one.line.resize(columns.size());
  Row sum(columns.size());
  std::uint8_t* out = half.rgba.data();
  for (const Taps& tap : rows) {
    std::fill(sum.begin(), sum.end(), Eigen::Array4f::Zero());
    for (std::size_t k = 0; k < tap.count; ++k) {
      Held& one = held[static_cast<std::size_t>(tap.texels[k]) % held.size()];
      if (one.row != tap.texels[k]) along(tap.texels[k], one.line);
      one.row = tap.texels[k];
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += tap.shares[k] * one.line[i];
    }
    for (const Eigen::Array4f& texel : sum) {
      const Eigen::Array4f mean = (texel / texel[3] + 0.5F).min(65535.0F);
      for (int c = 0; c < 3; ++c) out[c] = encoding.encoded(static_cast<std::uint16_t>(mean[c]));
      out[3] = static_cast<std::uint8_t>(255 * std::clamp(texel[3] - kUnseen, 0.0F, 1.0F) + 0.5F);
      out += 4;
    }
  }
  return half;
}

template <typename Halve>
std::vector<Texture> levels_of(const Texture& base, const Halve& halve) {
  std::vector<Texture> levels;
  const Texture* last = &base;
  while (last->width > 1 || last->height > 1) {
    levels.push_back(halve(*last));
    last = &levels.back();
  }
  return levels;
}

}  // namespace

std::vector<Texture> texture_levels(const Texture& base) {
  return levels_of(base, [](const Texture& last) { return halved(last); });
}

std::vector<Texture> light_levels(const Texture& base, bool repeat, const LightEncoding& encoding) {
  return levels_of(base, [&](const Texture& last) { return halved(last, repeat, encoding); });
}

}  // namespace holdfast
