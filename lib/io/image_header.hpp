#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace holdfast::io {

struct ImageSize {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
};

/// The size that an encoded image's header tells (PNG, JPEG, BMP, PNM, WebP, TIFF, JPEG 2000, Radiance), before
/// anything of it is decoded; nothing for another kind or a damaged header.
std::optional<ImageSize> image_size(std::string_view bytes);

/// EXIF's orientation of a JPEG, 1 to 8; 1 where it has none.
int jpeg_orientation(std::string_view bytes);

}  // namespace holdfast::io
