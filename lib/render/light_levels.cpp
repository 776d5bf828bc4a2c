#include "render/light_levels.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace holdfast {
namespace {

/// What a texel never seen weighs beside one that was: only where all are unseen its colour counts.
constexpr float kUnseen = 1e-4F;

/// The texels that one of the next level is a weighted mean of.
struct Taps {
  std::array<int, 5> texels{};
  std::array<float, 5> weights{};
  std::size_t count = 0;
};

std::vector<Taps> taps(int size, int half_size, bool repeat) {
  std::vector<Taps> result(static_cast<std::size_t>(half_size));
  const double step = static_cast<double>(size) / half_size;
  for (int i = 0; i < half_size; ++i) {
    const double begin = i * step, end = begin + step;
    const auto share = [&](int texel) {
      return std::max(0.0, std::min(end, texel + 1.0) - std::max(begin, static_cast<double>(texel))) / step;
    };
    const int first = static_cast<int>(begin + 1e-9), last = static_cast<int>(end - 1e-9);
    Taps& tap = result[static_cast<std::size_t>(i)];
    for (int texel = first - 1; texel <= last + 1; ++texel) {
      // The level's own area, blurred by 1 2 1.
      const double weight = 0.25 * share(texel - 1) + 0.5 * share(texel) + 0.25 * share(texel + 1);
      tap.texels[tap.count] = repeat ? (texel + size) % size : std::clamp(texel, 0, size - 1);
      tap.weights[tap.count++] = static_cast<float>(weight);
    }
  }
  return result;
}

/// A row of light, weighted by alpha, and of what that weighs.
using Row = std::vector<Eigen::Array4f>;

Texture halved(const Texture& source, bool repeat, const LightEncoding& encoding) {
  Texture half;
  half.width = std::max(1, source.width / 2);
  half.height = std::max(1, source.height / 2);
  const std::vector<Taps> columns = taps(source.width, half.width, repeat);
  const std::vector<Taps> rows = taps(source.height, half.height, repeat);
  half.rgba.resize(columns.size() * rows.size() * 4);

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
        sum += columns[i].weights[k] * light[static_cast<std::size_t>(columns[i].texels[k])];
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
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += tap.weights[k] * one.line[i];
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

}  // namespace

std::vector<Texture> light_levels(const Texture& base, bool repeat, const LightEncoding& encoding) {
  std::vector<Texture> levels;
  const Texture* last = &base;
  while (last->width > 1 || last->height > 1) {
    levels.push_back(halved(*last, repeat, encoding));
    last = &levels.back();
  }
  return levels;
}

}  // namespace holdfast
