#include "photometry.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// What the object's pair weighs against a tile's own pixels: as much as this many pixels of this contrast.
constexpr double kPriorPixels = 40;
constexpr double kPriorVariance = 0.05 * 0.05;
constexpr double kLeastGain = 0.2, kMostGain = 4.0;

struct Moments {
  double w = 0, v = 0, i = 0, vv = 0, ii = 0, vi = 0;

  void add(const float* sums) {
    w += static_cast<double>(sums[0]);
    v += static_cast<double>(sums[1]);
    i += static_cast<double>(sums[2]);
    vv += static_cast<double>(sums[3]);
    ii += static_cast<double>(sums[4]);
    vi += static_cast<double>(sums[5]);
  }
  double centered_vv() const { return w > 0 ? std::max(0.0, vv - v * v / w) : 0; }
  double centered_ii() const { return w > 0 ? std::max(0.0, ii - i * i / w) : 0; }
  double centered_vi() const { return w > 0 ? vi - v * i / w : 0; }
};

}  // namespace

Photometry::Photometry(const Device::Impl& device, const std::vector<Level>& levels, bool enabled)
    : device_(device), levels_(levels), enabled_(enabled) {
  for (const Level& level : levels) {
    TilePhotometry tiles;
    const std::size_t count = static_cast<std::size_t>(level.tiles_x()) * static_cast<std::size_t>(level.tiles_y());
    tiles.values.resize(count * HF_TILE_PHOTO);
    tiles.buffer = device.zeroed_buffer(tiles.values.size() * sizeof(float));
    tiles_.push_back(std::move(tiles));
  }
  reset();
}

void Photometry::reset() {
  gain_.fill(1);
  bias_.fill(0);
  for (std::size_t l = 0; l < tiles_.size(); ++l) {
    start_level(static_cast<int>(l), {0, 0, levels_[l].tiles_x(), levels_[l].tiles_y()}, false);
  }
}

void Photometry::start_level(int level, const kernel::hf_rect& tiles, bool from_coarser) {
  const auto l = static_cast<std::size_t>(level);
  auto& values = tiles_[l].values;
  const int stride = levels_[l].tiles_x();
  for (int ty = tiles.y; ty < tiles.y + tiles.height; ++ty) {
    for (int tx = tiles.x; tx < tiles.x + tiles.width; ++tx) {
      float* pair = values.data() + static_cast<std::size_t>(HF_TILE_PHOTO * (ty * stride + tx));
      if (from_coarser) {
        const int coarse_stride = levels_[l + 1].tiles_x();
        const float* coarse =
            tiles_[l + 1].values.data() + static_cast<std::size_t>(HF_TILE_PHOTO * ((ty / 2) * coarse_stride + tx / 2));
        std::copy(coarse, coarse + 2 * HF_CHANNELS, pair);
        continue;
      }
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        pair[c] = static_cast<float>(gain_[c]);
        pair[HF_CHANNELS + c] = static_cast<float>(bias_[c]);
      }
    }
  }
}

void Photometry::update(int level, const FlowConstraints& constraints) {
  if (!enabled_) return;
  const auto l = static_cast<std::size_t>(level);
  const kernel::hf_rect tiles = constraints.tiles();
  const auto& sums = constraints.tile_sums();
  const int stride = levels_[l].tiles_x();
  auto& values = tiles_[l].values;

  for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
    const std::size_t photo = HF_SUM_PHOTO + HF_PHOTO * c;
    const auto tile_sums = [&](int column, int row) {
      return sums.data() + static_cast<std::size_t>(row * tiles.width + column) * HF_SUM_STRIDE + photo;
    };
    Moments object;
    for (int row = 0; row < tiles.height; ++row) {
      for (int column = 0; column < tiles.width; ++column) object.add(tile_sums(column, row));
    }
    if (object.w > kPriorPixels) {
      // Moments, not regression: a misaligned view has the right spread but not the right correlation.
      const double prior = kPriorPixels * kPriorVariance;
      const double gain =
          std::sqrt((object.centered_ii() + prior * gain_[c] * gain_[c]) / (object.centered_vv() + prior));
      gain_[c] = std::clamp(gain, kLeastGain, kMostGain);
      bias_[c] = (object.i - gain_[c] * object.v) / object.w;
    }
    for (int row = 0; row < tiles.height; ++row) {
      for (int column = 0; column < tiles.width; ++column) {
        Moments near;
        for (int r = std::max(0, row - 1); r <= std::min(tiles.height - 1, row + 1); ++r) {
          for (int k = std::max(0, column - 1); k <= std::min(tiles.width - 1, column + 1); ++k) {
            near.add(tile_sums(k, r));
          }
        }
        const double prior = kPriorPixels * kPriorVariance;
        const double gain =
            std::clamp(std::sqrt((near.centered_ii() + prior * gain_[c] * gain_[c]) / (near.centered_vv() + prior)),
                       kLeastGain, kMostGain);
        // The object's pair, seen at this tile's mean, is what few pixels are drawn to.
        const double mean_v = near.w > 0 ? near.v / near.w : object.w > 0 ? object.v / object.w : 0.5;
        const double expected = gain_[c] * mean_v + bias_[c];
        const double mean_i = (near.i + kPriorPixels * 0.25 * expected) / (near.w + kPriorPixels * 0.25);
        float* pair =
            values.data() + static_cast<std::size_t>(HF_TILE_PHOTO * ((tiles.y + row) * stride + tiles.x + column));
        pair[c] = static_cast<float>(gain);
        pair[HF_CHANNELS + c] = static_cast<float>(mean_i - gain * mean_v);
      }
    }
  }
}

void Photometry::enqueue_upload(int level, const kernel::hf_rect& tiles) {
  const auto l = static_cast<std::size_t>(level);
  const auto row = static_cast<std::size_t>(levels_[l].tiles_x()) * HF_TILE_PHOTO;
  const std::size_t first = static_cast<std::size_t>(tiles.y) * row;
  const std::size_t count = static_cast<std::size_t>(tiles.height) * row;
  if (count == 0) return;
  device_.queue.enqueueWriteBuffer(tiles_[l].buffer, CL_FALSE, first * sizeof(float), count * sizeof(float),
                                   tiles_[l].values.data() + first);
}

double Photometry::correlation(const FlowConstraints& constraints) {
  const kernel::hf_rect tiles = constraints.tiles();
  double vv = 0, ii = 0, vi = 0;
  const std::size_t count = static_cast<std::size_t>(tiles.width) * static_cast<std::size_t>(tiles.height);
  for (std::size_t tile = 0; tile < count; ++tile) {
    for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
      Moments moments;
      moments.add(constraints.tile_sums().data() + tile * HF_SUM_STRIDE + HF_SUM_PHOTO + HF_PHOTO * c);
      vv += moments.centered_vv();
      ii += moments.centered_ii();
      vi += moments.centered_vi();
    }
  }
  return vv > 0 && ii > 0 ? vi / std::sqrt(vv * ii) : 0;
}

}  // namespace holdfast
