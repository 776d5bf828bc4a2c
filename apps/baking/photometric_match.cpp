#include "baking/photometric_match.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace holdfast::baking {
namespace {

constexpr std::size_t kFewestPairs = 100;
constexpr int kIterations = 6;
constexpr float kLeastGain = 0.4F, kMostGain = 2.5F;
/// Known before any pair, with the weight of this share of them: gain 1, no shading, no bias, give or take these. What
/// the pairs do not tell apart (the bias from the gain on one colour, the shading where all face one way) stays there.
constexpr double kPriorShare = 0.01;
constexpr double kNoise = 10, kGainDeviation = 0.3, kBiasDeviation = 10;

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// Unknowns: gain, shading (3), bias.
Vector5 row_of(const ColorPair& pair, std::size_t channel) {
  const double t = pair.texture[channel];
  Vector5 row;
  row << t, t * pair.normal.cast<double>(), 1;
  return row;
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

/// Least squares with Cauchy's weights of the residuals to the solution before.
Vector5 refit(const std::vector<ColorPair>& pairs, std::size_t channel, const Vector5& before, double scale) {
  Vector5 deviation;
  deviation << kGainDeviation, kGainDeviation, kGainDeviation, kGainDeviation, kBiasDeviation;
  const Vector5 precision =
      kPriorShare * static_cast<double>(pairs.size()) * kNoise * kNoise * deviation.array().square().inverse().matrix();
  Matrix5 A = precision.asDiagonal();
  Vector5 h = precision.cwiseProduct(Vector5::Unit(0));
  for (const ColorPair& pair : pairs) {
    const Vector5 row = row_of(pair, channel);
    const double y = pair.frame[channel];
    const double residual = (y - row.dot(before)) / scale;
    const double weight = 1 / (1 + residual * residual);
    A.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    h += weight * y * row;
  }
  return A.selfadjointView<Eigen::Lower>().ldlt().solve(h);
}

}  // namespace

ColorF PhotometricMatch::to_texture(const ColorF& frame, const Eigen::Vector3f& normal) const {
  ColorF texture{};
  for (std::size_t c = 0; c < 3; ++c) {
    const Channel& channel = channels[c];
    const float gain = std::clamp(channel.gain + channel.shading.dot(normal), kLeastGain, kMostGain);
    texture[c] = std::clamp((frame[c] - channel.bias) / gain, 0.0F, 255.0F);
  }
  return texture;
}

PhotometricMatch match_photometry(const std::vector<ColorPair>& pairs, double tolerance) {
  PhotometricMatch match;
  if (pairs.size() < kFewestPairs) {
    return match;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    Vector5 unknowns;
    unknowns << 1, 0, 0, 0, median_difference(pairs, c);
    double scale = 4 * tolerance;
    for (int i = 0; i < kIterations; ++i) {
      unknowns = refit(pairs, c, unknowns, scale);
      scale = std::max(0.5 * tolerance, 0.6 * scale);
    }
    match.channels[c] = {static_cast<float>(unknowns[0]), unknowns.segment<3>(1).cast<float>(),
                         static_cast<float>(unknowns[4])};
  }
  return match;
}

}  // namespace holdfast::baking
