#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::simulation {

/// A texture in linear light with its area-averaged pyramid.
class MipTexture {
 public:
  explicit MipTexture(const Texture& texture);
  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

  /// The part of the texture that a sample stands for, texels of the finest level: probes in a row, each averaging a
  /// square.
  struct Footprint {
    int probes = 1;
    Eigen::Vector2f step = Eigen::Vector2f::Zero();  ///< from probe to probe
    float level = 0;                                 ///< of the pyramid: log2 of the square's side
  };
  /// `across` and `down`: what the texture coordinate moves by from one sample to the next.
  static Footprint footprint(const Eigen::Vector2f& across, const Eigen::Vector2f& down);

  /// Linear BGR averaged over a footprint round `texel`. `repeat`: coordinates outside the texture wrap round.
  Eigen::Array3f sample(const Eigen::Vector2f& texel, const Footprint& footprint, bool repeat) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    float scale_x = 1;  // texels of this level a texel of the finest
    float scale_y = 1;
    std::vector<std::array<std::uint16_t, 4>> texels;  // linear BGR, 65535 is white; the fourth is unused
  };
  Eigen::Array4f trilinear(const Eigen::Vector2f& texel, float level, bool repeat) const;
  static Eigen::Array4f bilinear(const Level& level, float x, float y, bool repeat);

  std::vector<Level> levels_;
};

}  // namespace holdfast::simulation
