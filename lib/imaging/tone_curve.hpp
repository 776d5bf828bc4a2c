#pragma once

#include <span>

#include "imaging/shading.hpp"

namespace holdfast {

/// How the camera encodes brightness beside how the texture has it: as a power of it, one for all channels (equation
/// 15c of docs/math.md). Gain and bias stand for it where contrast is low; not where light falls off over a texture of
/// its own.
class ToneCurve {
 public:
  /// The power that the view is to be drawn with (above 1: darker): exactly 1 until the frames show clearly that it is
  /// another.
  double drawn() const { return drawn_; }

  /// Takes the patches of one more frame into account, read when it was drawn() so. `shading` is fitted to them.
  void learn(std::span<const LitPatch> patches, const Shading& shading);

 private:
  double drawn_ = 1;
  /// Normal equation of the power's logarithm from the frames so far, the older the less.
  double A_ = 0, h_ = 0;
};

}  // namespace holdfast
