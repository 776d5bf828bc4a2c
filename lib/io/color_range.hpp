#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace holdfast::io {

/// Full colour in a file whose format leaves it open: the largest value tells, of red, green and blue together
/// and of alpha, since one dark colour does not.
class ColorRange {
 public:
  /// Takes a value into account; channels 0 to 3 are red to alpha.
  void note(std::size_t channel, double value) {
    double& most = channel == 3 ? alpha_ : color_;
    most = std::max(most, value);
  }

  /// Full colour of shares of 1 or numbers up to 255: shares are rounded up by less.
  double full(std::size_t channel) const { return most(channel) > 2 ? 255 : 1; }
  /// Full colour in 16 bits, in which programs write numbers up to 255 too.
  double full_of_16_bits(std::size_t channel) const { return most(channel) > 255 ? 65535 : 255; }

 private:
  double most(std::size_t channel) const { return channel == 3 ? alpha_ : color_; }

  double color_ = 0, alpha_ = 0;
};

inline std::uint8_t color_byte(double value, double full) {
  return static_cast<std::uint8_t>(std::lround(std::isnan(value) ? 0 : std::clamp(value * 255 / full, 0.0, 255.0)));
}

}  // namespace holdfast::io
