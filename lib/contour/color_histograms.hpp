#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "device/shared.h"

namespace holdfast {

/// The bin of a pixel's first three channels, each 0 to 1.
inline int color_bin(const float* pixel) {
  constexpr int kMost = (1 << HF_COLOR_BITS) - 1;
  const auto part = [&](int i) { return std::clamp(static_cast<int>(pixel[i] * (kMost + 1)), 0, kMost); };
  return (part(0) << HF_COLOR_BITS | part(1)) << HF_COLOR_BITS | part(2);
}

/// Which colours belong to the object and which to what is behind it, as seen along the object's contour (equation 24
/// of docs/math.md).
class ColorHistograms {
 public:
  static constexpr std::size_t kBins = std::size_t{1} << (3 * HF_COLOR_BITS);

  ColorHistograms() { clear(); }
  void clear();
  bool known() const { return known_; }
  /// Adds a frame: `bins` holds lines of 2 `reach` + 1 bins from the inside out, the contour in the middle; -1: none.
  void learn(std::span<const int> bins, int reach);
  /// Of each bin, how likely a pixel of that colour shows the object, where it is as likely as not to do so.
  const std::vector<float>& share() const { return share_; }

 private:
  std::vector<float> object_, background_;  ///< frequency of each bin
  std::vector<float> share_;
  std::vector<float> count_;  ///< of the frame being added
  bool known_ = false;

  /// False where no pixel of that side is there.
  bool add(std::span<const int> bins, int reach, bool inside, std::vector<float>& frequency);
};

}  // namespace holdfast
