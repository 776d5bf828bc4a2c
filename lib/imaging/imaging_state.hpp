#pragma once

#include <algorithm>
#include <cmath>

#include "imaging/shading.hpp"
#include "texture/texture_modality.hpp"

namespace holdfast {

/// Whether what blurs the frames is motion, which blurs along itself alone: a lens blurs, and noise is averaged, in any
/// direction. By how much better views fit that are blurred along the motion, and as much across it, than sharp ones.
class BlurDirections {
 public:
  /// Scores of the three. In fast frames they differ most, so that these count most.
  void add(double sharp, double along, double across) {
    constexpr double kMemory = 0.8;
    along_ = kMemory * along_ + gain(along, sharp);
    across_ = kMemory * across_ + gain(across, sharp);
  }
  /// Whether clearly more is gained along the motion than across it.
  bool along_motion() const { return across_ < 0.65 * along_; }

 private:
  static double gain(double score, double sharp) {
    constexpr double kLeast = 1e-3;
    return std::log(std::max(score, kLeast) / std::max(sharp, kLeast));
  }

  double along_ = 0, across_ = 0;  ///< logarithms, added up
};

/// How long the shutter is open, as measured in fast frames.
struct ExposureState {
  double share = 0;     ///< of the time between frames
  bool light = false;   ///< what adds up meanwhile is light, not encoded values
  int settled = 0;      ///< how often measuring it has changed nothing
  int fast_frames = 0;  ///< since it was measured
  BlurDirections directions;

  bool known() const { return settled >= 3; }
};

/// Whether texels are averaged as the light that they stand for, as cameras do it, or as encoded values, as many a
/// renderer does it; measured.
struct TexelState {
  bool light = true;
  double evidence = 0;  ///< for light: logarithm of how much more is left over without, running mean
  int measured = 0;     ///< of how many measurements that is, at most eight
  int frames = 0;       ///< since it was measured
};

/// How this camera shows this model, as learned from the frames. A value: alignments take it and return what they have
/// learned; the pipeline keeps that of a frame that was held.
struct ImagingState {
  TextureState texture;
  ExposureState exposure;
  TexelState texels;
  Shading shading;
  bool lit = true;             ///< the view is drawn with this shading
  double surviving_share = 1;  ///< of the visible pixels, off the silhouette margin, on the finest level
};

}  // namespace holdfast
