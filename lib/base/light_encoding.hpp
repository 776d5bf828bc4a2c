#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace holdfast {

/// Encoded values of a picture (sRGB, IEC 61966-2-1) as the light they stand for, and back: what averages values must
/// average light where it does as a camera does.
class LightEncoding {
 public:
  LightEncoding();
  std::uint16_t light(std::uint8_t encoded) const { return light_[encoded]; }  ///< 65535 is white
  std::uint8_t encoded(std::uint16_t light) const { return encoded_[light]; }

 private:
  std::array<std::uint16_t, 256> light_{};
  std::vector<std::uint8_t> encoded_;
};

}  // namespace holdfast
