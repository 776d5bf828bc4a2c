#include "simulation/mip_texture.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/light_encoding.hpp"

namespace holdfast::simulation {
namespace {

std::array<std::uint16_t, 256> linear_table() {
  std::array<std::uint16_t, 256> table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<std::uint16_t>(std::lround(65535.0 * linear_from_encoded(static_cast<double>(i) / 255.0)));
  }
  return table;
}

}  // namespace

MipTexture::MipTexture(const Texture& texture) {
  const std::array<std::uint16_t, 256> linear = linear_table();
  Level finest;
  finest.width = texture.width;
  finest.height = texture.height;
  finest.texels.resize(static_cast<std::size_t>(texture.width) * texture.height);
  for (std::size_t i = 0; i < finest.texels.size(); ++i) {
    const std::uint8_t* rgba = &texture.rgba[4 * i];
    finest.texels[i] = {linear[rgba[2]], linear[rgba[1]], linear[rgba[0]], 0};
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.width = std::max(1, fine.width / 2);
    coarse.height = std::max(1, fine.height / 2);
    coarse.texels.resize(static_cast<std::size_t>(coarse.width) * coarse.height);
    // Sides need not be powers of two: each coarse texel averages the fine ones that its square covers.
    for (int y = 0; y < coarse.height; ++y) {
      const int y0 = y * fine.height / coarse.height;
      const int y1 = std::max(y0 + 1, (y + 1) * fine.height / coarse.height);
      for (int x = 0; x < coarse.width; ++x) {
        const int x0 = x * fine.width / coarse.width;
        const int x1 = std::max(x0 + 1, (x + 1) * fine.width / coarse.width);
        std::array<std::uint32_t, 3> sum{};
        for (int yy = y0; yy < y1; ++yy) {
          for (int xx = x0; xx < x1; ++xx) {
            const auto& texel = fine.texels[static_cast<std::size_t>(yy) * fine.width + xx];
            for (std::size_t k = 0; k < 3; ++k) sum[k] += texel[k];
          }
        }
        const std::uint32_t count = static_cast<std::uint32_t>((y1 - y0) * (x1 - x0));
        auto& texel = coarse.texels[static_cast<std::size_t>(y) * coarse.width + x];
        for (std::size_t k = 0; k < 3; ++k) texel[k] = static_cast<std::uint16_t>((sum[k] + count / 2) / count);
      }
    }
    coarse.scale_x = static_cast<float>(coarse.width) / static_cast<float>(width());
    coarse.scale_y = static_cast<float>(coarse.height) / static_cast<float>(height());
    levels_.push_back(std::move(coarse));
  }
}

Eigen::Array4f MipTexture::bilinear(const Level& level, float x, float y, bool repeat) {
  const auto floor_of = [](float value) {
    const int truncated = static_cast<int>(value);
    return truncated - (static_cast<float>(truncated) > value ? 1 : 0);
  };
  const auto place = [repeat](int index, int size) {
    if (!repeat) return std::clamp(index, 0, size - 1);
    const int rest = index % size;
    return rest < 0 ? rest + size : rest;
  };
  const int left = floor_of(x);
  const int top = floor_of(y);
  const float share_x = x - static_cast<float>(left);
  const float share_y = y - static_cast<float>(top);
  const int x0 = place(left, level.width), x1 = place(left + 1, level.width);
  const std::size_t y0 = static_cast<std::size_t>(place(top, level.height)) * level.width;
  const std::size_t y1 = static_cast<std::size_t>(place(top + 1, level.height)) * level.width;
  const auto load = [&](std::size_t i) {
    const auto& texel = level.texels[i];
    return Eigen::Array4f(texel[0], texel[1], texel[2], texel[3]);
  };
  const float right_share = share_x * (1.0f / 65535.0f);
  const float left_share = 1.0f / 65535.0f - right_share;
  const Eigen::Array4f upper = load(y0 + x0) * left_share + load(y0 + x1) * right_share;
  const Eigen::Array4f lower = load(y1 + x0) * left_share + load(y1 + x1) * right_share;
  return upper + (lower - upper) * share_y;
}

Eigen::Array4f MipTexture::trilinear(const Eigen::Vector2f& texel, float level, bool repeat) const {
  const float clamped = std::clamp(level, 0.0f, static_cast<float>(levels_.size() - 1));
  const std::size_t fine = static_cast<std::size_t>(clamped);
  const float share = clamped - static_cast<float>(fine);
  const auto at = [&](const Level& l) {
    return bilinear(l, (texel.x() + 0.5f) * l.scale_x - 0.5f, (texel.y() + 0.5f) * l.scale_y - 0.5f, repeat);
  };
  const Eigen::Array4f value = at(levels_[fine]);
  if (share < 0.01f || fine + 1 == levels_.size()) return value;
  return value + (at(levels_[fine + 1]) - value) * share;
}

MipTexture::Footprint MipTexture::footprint(const Eigen::Vector2f& across, const Eigen::Vector2f& down) {
  Footprint result;
  const Eigen::Vector2f& longer = across.squaredNorm() > down.squaredNorm() ? across : down;
  const float longest = longer.norm();
  if (longest <= 1.0f) return result;
  // The footprint's width is its area over its length: right for sheared footprints too.
  const float width = std::abs(across.x() * down.y() - across.y() * down.x()) / longest;
  // Surfaces seen at a slant are averaged along the footprint, not blurred in both directions.
  result.probes = std::clamp(static_cast<int>(std::ceil(longest / std::max(width, 0.5f) - 0.5f)), 1, 8);
  result.step = longer / static_cast<float>(result.probes);
  result.level = std::log2(std::max(longest / static_cast<float>(result.probes), 1.0f));
  return result;
}

Eigen::Array3f MipTexture::sample(const Eigen::Vector2f& texel, const Footprint& footprint, bool repeat) const {
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int i = 0; i < footprint.probes; ++i) {
    const float along = static_cast<float>(i) - 0.5f * static_cast<float>(footprint.probes - 1);
    sum += trilinear(texel + along * footprint.step, footprint.level, repeat);
  }
  return sum.head<3>() / static_cast<float>(footprint.probes);
}

}  // namespace holdfast::simulation
