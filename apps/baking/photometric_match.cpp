#include "baking/photometric_match.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast::baking {
namespace {

constexpr std::size_t kFewestPairs = 100;
constexpr int kIterations = 6;
constexpr double kLeastGain = 0.4, kMostGain = 2.5;
/// A bias is told from a gain only where the texture's colours spread this much, levels.
constexpr double kLeastSpread = 12;

struct Line {
  double gain = 1;
  double bias = 0;
};

/// Weighted least squares; the weights are Cauchy's of the residuals to the line before.
Line refit(const std::vector<ColorPair>& pairs, std::size_t channel, const Line& before, double scale) {
  double w = 0, t = 0, f = 0, tt = 0, tf = 0;
  for (const ColorPair& pair : pairs) {
    const double x = pair.texture[channel];
    const double y = pair.frame[channel];
    const double residual = (y - before.gain * x - before.bias) / scale;
    const double weight = 1 / (1 + residual * residual);
    w += weight;
    t += weight * x;
    f += weight * y;
    tt += weight * x * x;
    tf += weight * x * y;
  }
  const double variance = tt / w - t / w * (t / w);
  Line line;
  if (variance > kLeastSpread * kLeastSpread) {
    line.gain = std::clamp((tf / w - t / w * (f / w)) / variance, kLeastGain, kMostGain);
    line.bias = f / w - line.gain * t / w;
  } else {
    line.gain = t > 0 ? std::clamp(f / t, kLeastGain, kMostGain) : 1.0;
  }
  return line;
}

double median_difference(const std::vector<ColorPair>& pairs, std::size_t channel) {
  std::vector<float> differences;
  differences.reserve(pairs.size());
  for (const ColorPair& pair : pairs) {
    differences.push_back(pair.frame[channel] - pair.texture[channel]);
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

}  // namespace

std::array<float, 3> PhotometricMatch::to_texture(const std::array<float, 3>& frame) const {
  std::array<float, 3> texture{};
  for (std::size_t c = 0; c < 3; ++c) {
    texture[c] = std::clamp((frame[c] - bias[c]) / gain[c], 0.0F, 255.0F);
  }
  return texture;
}

PhotometricMatch match_photometry(const std::vector<ColorPair>& pairs, float tolerance) {
  PhotometricMatch match;
  match.pairs = pairs.size();
  if (pairs.size() < kFewestPairs) {
    return match;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    Line line{1, median_difference(pairs, c)};
    double scale = 4.0 * tolerance;
    for (int i = 0; i < kIterations; ++i) {
      line = refit(pairs, c, line, scale);
      scale = std::max<double>(0.5 * tolerance, 0.6 * scale);
    }
    match.gain[c] = static_cast<float>(line.gain);
    match.bias[c] = static_cast<float>(line.bias);
  }
  std::size_t agreeing = 0;
  for (const ColorPair& pair : pairs) {
    float difference = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      difference += std::abs(pair.frame[c] - match.gain[c] * pair.texture[c] - match.bias[c]);
    }
    agreeing += difference <= 3 * tolerance ? 1 : 0;
  }
  match.agreement = static_cast<float>(agreeing) / static_cast<float>(pairs.size());
  return match;
}

}  // namespace holdfast::baking
