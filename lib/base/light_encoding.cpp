#include "base/light_encoding.hpp"

#include <cmath>

namespace holdfast {
namespace {

double light_of(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace

LightEncoding::LightEncoding() : encoded_(65536) {
  for (std::size_t i = 0; i < light_.size(); ++i) {
    light_[i] = static_cast<std::uint16_t>(std::lround(65535 * light_of(static_cast<double>(i) / 255)));
  }
  // From one value to the next in the middle between both, encoded.
  std::size_t value = 0;
  for (std::size_t light = 0; light < encoded_.size(); ++light) {
    while (value < 255 && static_cast<double>(light) > 65535 * light_of((static_cast<double>(value) + 0.5) / 255)) {
      ++value;
    }
    encoded_[light] = static_cast<std::uint8_t>(value);
  }
}

}  // namespace holdfast
