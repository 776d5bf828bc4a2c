#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace holdfast::baking {

using ColorF = std::array<float, 3>;  ///< BGR, levels of 255

/// The same surface point in the texture and in a frame.
struct ColorPair {
  ColorF texture;
  ColorF frame;
  Eigen::Vector3f normal;  ///< of the surface, object frame, unit length
};

/// frame = gain(normal) * texture + bias, a channel: exposure and white balance change the gain of all surfaces alike,
/// turning in the light changes it linearly in the normal (Lambert, one far light).
struct PhotometricMatch {
  struct Channel {
    float gain = 1;
    Eigen::Vector3f shading = Eigen::Vector3f::Zero();
    float bias = 0;
  };
  std::array<Channel, 3> channels;

  /// What the texture would show where the frame shows this colour.
  ColorF to_texture(const ColorF& frame, const Eigen::Vector3f& normal) const;
};

/// Robust fit: pairs that differ by much more than `tolerance` (levels) do not count. Identity without enough pairs.
PhotometricMatch match_photometry(const std::vector<ColorPair>& pairs, double tolerance);

}  // namespace holdfast::baking
