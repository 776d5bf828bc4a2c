#include "imaging/tone_curve.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// That the power is 1 weighs as much as this square of contrast on every pixel of a frame.
constexpr double kPriorContrast2 = 0.002;
/// Of what earlier frames told, what counts on in the next.
constexpr double kMemory = 0.8;
/// Of the power's logarithm, that it is drawn from, and what of that it must fall to to be drawn no more.
constexpr double kLeastDrawn = 0.1, kStillDrawn = 0.7;
/// Of the power's logarithm: no camera's is farther from another's.
constexpr double kMost = 1.1;
constexpr std::size_t kLeastPatches = 10;

}  // namespace

void ToneCurve::learn(std::span<const LitPatch> patches, const Shading& shading) {
  if (patches.size() < kLeastPatches) return;
  // Brightness over the mean is what light makes of it, given by four numbers, and what is left to the power: in
  // proportion to the texture's logarithm.
  double total = 0, brightness = 0, light = 0;
  for (const LitPatch& patch : patches) {
    total += patch.weight;
    brightness += patch.weight * patch.brightness;
    light += patch.weight * shading.of(patch.normal);
  }
  if (total <= 0 || brightness <= 0) return;
  const auto pixels = static_cast<double>(patches.size());
  Eigen::Matrix4d among_light = Eigen::Matrix4d::Zero();
  Eigen::Vector4d with_texture = Eigen::Vector4d::Zero(), with_brightness = Eigen::Vector4d::Zero();
  double texture2 = 0, texture_brightness = 0;
  for (const LitPatch& patch : patches) {
    const double seen = patch.brightness / brightness * total, lit = shading.of(patch.normal) / light * total;
    const double weight = patch.weight * (pixels / total) / doubt(seen - lit);
    const Eigen::Vector4d terms(1, patch.normal.x(), patch.normal.y(), patch.normal.z());
    among_light += weight * terms * terms.transpose();
    with_texture += weight * patch.log_texture * terms;
    with_brightness += weight * seen * terms;
    texture2 += weight * patch.log_texture * patch.log_texture;
    texture_brightness += weight * patch.log_texture * seen;
  }
  // One face alone does not tell light's direction, nor need it.
  among_light.diagonal().tail<3>().array() += 1e-3 * pixels;
  const Eigen::Vector4d eliminated = among_light.ldlt().solve(with_texture);
  const double A = texture2 - eliminated.dot(with_texture);
  const double h = texture_brightness - eliminated.dot(with_brightness);
  if (!(A > 0) || !std::isfinite(h)) return;
  const double off = std::clamp(h / A, -0.5, 0.5);
  A_ = kMemory * A_ + A;
  h_ = kMemory * h_ + A * (std::log(drawn_) + std::log1p(off));
  const double power = std::clamp(h_ / (A_ + kPriorContrast2 * pixels), -kMost, kMost);
  const bool clearly = std::abs(power) > kLeastDrawn * (drawn_ == 1 ? 1 : kStillDrawn);
  drawn_ = clearly ? std::exp(power) : 1;
}

}  // namespace holdfast
