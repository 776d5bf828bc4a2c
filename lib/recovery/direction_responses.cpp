#include "recovery/direction_responses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace holdfast {
namespace {

/// Squared step of colour over two pixels below which a gradient is noise: four levels a pixel.
constexpr float kNoise2 = (8.0F / 255) * (8.0F / 255);
/// Response to an edge of the next direction, and what one across takes away, of 1.
constexpr float kNext = 0.6F, kAcross = 0.33F;
/// Pixels around one over which what an edge says is averaged: where there are many, one says little.
constexpr int kAround = 6;
/// Pixels on either side of a contour that its colours are looked at.
constexpr double kBeside = 2;
/// Share of colours in a contour's response.
constexpr float kColors = 0.5F;

std::uint8_t level_of(float value) {
  constexpr float kRange = 255 - DirectionResponses::kNothing;
  return static_cast<std::uint8_t>(std::clamp(static_cast<int>(DirectionResponses::kNothing + kRange * value), 0, 255));
}

}  // namespace

int DirectionResponses::direction(double x, double y) {
  const int turn = static_cast<int>(std::lround(std::atan2(y, x) / std::numbers::pi * kEdges));
  return (turn + kContours) % kContours;
}

/// Pixels at which the gradient is largest along its direction.
void DirectionResponses::find_edges(const float* rgb, int stride) {
  const auto size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  strength_.assign(size, 0.0F);
  own_.assign(size, 0);
  std::vector<std::uint8_t>& directions = seen_;
  directions.assign(size, 0);
  for (int y = 1; y + 1 < height_; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      const float* here = rgb + 4 * (static_cast<std::ptrdiff_t>(y) * stride + x);
      float best = kNoise2, best_x = 0, best_y = 0;
      for (int c = 0; c < 3; ++c) {
        const float dx = here[4 + c] - here[c - 4], dy = here[4 * stride + c] - here[c - 4 * stride];
        const float square = dx * dx + dy * dy;
        if (square <= best) continue;
        best = square;
        best_x = dx;
        best_y = dy;
      }
      if (best_x == 0 && best_y == 0) continue;
      strength_[index(x, y)] = best;
      directions[index(x, y)] =
          static_cast<std::uint8_t>(direction(static_cast<double>(best_x), static_cast<double>(best_y)));
    }
  }
  for (int y = 1; y + 1 < height_; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      const float strength = strength_[index(x, y)];
      if (strength <= 0) continue;
      const int turn = directions[index(x, y)];
      const double angle = turn * std::numbers::pi / kEdges;
      const int sx = static_cast<int>(std::lround(std::cos(angle))),
                sy = static_cast<int>(std::lround(std::sin(angle)));
      if (strength_[index(x + sx, y + sy)] > strength || strength_[index(x - sx, y - sy)] >= strength) continue;
      own_[index(x, y)] = static_cast<std::uint8_t>(1U << (turn % kEdges));
    }
  }
  // An edge is seen by the pixels around it, too.
  std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
  for (int y = 1; y + 1 < height_; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      std::uint8_t bits = 0;
      for (int v = -1; v <= 1; ++v) {
        for (int u = -1; u <= 1; ++u) bits = static_cast<std::uint8_t>(bits | own_[index(x + u, y + v)]);
      }
      seen_[index(x, y)] = bits;
    }
  }
}

/// Responses to a direction, less their mean all around.
std::vector<float> DirectionResponses::beside_others(const float* value) const {
  const int across = width_ + 1;
  std::vector<float> said(seen_.size());
  std::vector<double> sums(std::size_t{1} * across * (height_ + 1));
  const auto sum = [&](int x, int y) -> double& { return sums[std::size_t{1} * y * across + x]; };
  for (int y = 0; y < height_; ++y) {
    double row = 0;
    for (int x = 0; x < width_; ++x) {
      row += static_cast<double>(std::max(0.0F, value[seen_[index(x, y)]]));
      sum(x + 1, y + 1) = sum(x + 1, y) + row;
    }
  }
  for (int y = 0; y < height_; ++y) {
    const int top = std::max(0, y - kAround), bottom = std::min(height_, y + kAround + 1);
    for (int x = 0; x < width_; ++x) {
      const int left = std::max(0, x - kAround), right = std::min(width_, x + kAround + 1);
      const double all = sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top);
      said[index(x, y)] = value[seen_[index(x, y)]] - static_cast<float>(all / ((right - left) * (bottom - top)));
    }
  }
  return said;
}

void DirectionResponses::compute(const float* rgb, int stride, const std::vector<float>& says, int width, int height,
                                 int margin) {
  width_ = width;
  height_ = height;
  margin_ = margin;
  columns_ = (width + 2 * margin + kStep - 1) / kStep;
  rows_ = (height + 2 * margin + kStep - 1) / kStep;
  find_edges(rgb, stride);
  planes_.assign(at(kEdges + kContours, 0, 0), std::uint8_t{kNothing});
  // What edges around a pixel say for each direction, of each set of them.
  float value[kEdges][1 << kEdges];
  for (int d = 0; d < kEdges; ++d) {
    const auto bit = [&](int by) { return 1U << ((d + by + kEdges) % kEdges); };
    for (unsigned bits = 0; bits < 1U << kEdges; ++bits) {
      const float along = (bits & bit(0)) != 0 ? 1.0F : (bits & (bit(-1) | bit(1))) != 0 ? kNext : 0.0F;
      const bool across = (bits & (bit(3) | bit(4) | bit(5))) != 0;
      value[d][bits] = along - (across ? kAcross : 0.0F);
    }
  }
  int beside_x[kContours], beside_y[kContours];
  for (int d = 0; d < kContours; ++d) {
    beside_x[d] = static_cast<int>(std::lround(kBeside * std::cos(d * std::numbers::pi / kEdges)));
    beside_y[d] = static_cast<int>(std::lround(kBeside * std::sin(d * std::numbers::pi / kEdges)));
  }
  std::vector<float> said[kEdges];
  for (int d = 0; d < kEdges; ++d) said[d] = beside_others(value[d]);
  const int border = static_cast<int>(kBeside);
  for (int y = border; y + border < height; ++y) {
    for (int x = border; x + border < width; ++x) {
      const std::size_t i = index(x, y);
      const auto response = [&](int plane) -> std::uint8_t& { return planes_[at(plane, x + margin, y + margin)]; };
      for (int d = 0; d < kEdges; ++d) response(d) = level_of(said[d][i]);
      for (int d = 0; d < kContours; ++d) {
        const std::ptrdiff_t across = static_cast<std::ptrdiff_t>(beside_y[d]) * width + beside_x[d];
        const float* here = says.data() + i;
        const float contrast = 0.5F * (here[-across] - here[across]);
        response(kEdges + d) = level_of((1 - kColors) * said[d % kEdges][i] + kColors * contrast);
      }
    }
  }
}

}  // namespace holdfast
