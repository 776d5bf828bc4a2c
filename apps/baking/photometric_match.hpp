#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace holdfast::baking {

/// The same surface point in the texture and in a frame, BGR.
struct ColorPair {
  std::array<float, 3> texture;
  std::array<float, 3> frame;
};

/// frame = gain * texture + bias, a channel; levels of 255.
struct PhotometricMatch {
  std::array<float, 3> gain{1, 1, 1};
  std::array<float, 3> bias{0, 0, 0};
  float agreement = 1;  ///< share of the pairs that the match explains to within `tolerance`
  std::size_t pairs = 0;

  /// What the texture would show where the frame shows this colour.
  std::array<float, 3> to_texture(const std::array<float, 3>& frame) const;
};

/// Robust fit; without enough pairs nothing is changed. `tolerance`: levels, the mean over the channels.
PhotometricMatch match_photometry(const std::vector<ColorPair>& pairs, float tolerance);

}  // namespace holdfast::baking
