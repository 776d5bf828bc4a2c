#include "io/image_header.hpp"

#include <algorithm>
#include <cstddef>

#include "io/numbers.hpp"

namespace holdfast::io {
namespace {

/// Bytes of an image; what lies beyond its end is 0.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::uint64_t at(std::size_t place) const {
    return place < bytes_.size() ? static_cast<unsigned char>(bytes_[place]) : 0;
  }
  std::uint64_t big(std::size_t place, std::size_t count) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) value = value << 8 | at(place + i);
    return value;
  }
  std::uint64_t little(std::size_t place, std::size_t count) const {
    std::uint64_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8 | at(place + i);
    return value;
  }
  std::size_t size() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

std::optional<ImageSize> jpeg_size(const Bytes& bytes) {
  for (std::size_t at = 2; at + 9 < bytes.size() && bytes.at(at) == 0xff;) {
    const std::uint64_t marker = bytes.at(at + 1);
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return ImageSize{bytes.big(at + 7, 2), bytes.big(at + 5, 2)};
    at += 2 + static_cast<std::size_t>(bytes.big(at + 2, 2));
  }
  return std::nullopt;
}

std::optional<ImageSize> bmp_size(const Bytes& bytes) {
  if (bytes.little(14, 4) == 12) return ImageSize{bytes.little(18, 2), bytes.little(20, 2)};
  const auto height = static_cast<std::int32_t>(bytes.little(22, 4));  // negative: rows from the top
  return ImageSize{bytes.little(18, 4), static_cast<std::uint64_t>(height < 0 ? -std::int64_t{height} : height)};
}

std::optional<ImageSize> webp_size(const Bytes& bytes, std::string_view kind) {
  if (kind == "VP8X") return ImageSize{bytes.little(24, 3) + 1, bytes.little(27, 3) + 1};
  if (kind == "VP8L") {
    const std::uint64_t bits = bytes.little(21, 4);
    return ImageSize{(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1};
  }
  return ImageSize{bytes.little(26, 2) & 0x3fff, bytes.little(28, 2) & 0x3fff};
}

/// A number of a TIFF file's first directory, by its tag.
std::optional<std::uint64_t> tiff_value(const Bytes& bytes, bool big, std::uint64_t wanted) {
  const auto value = [&](std::size_t place, std::size_t count) {
    return big ? bytes.big(place, count) : bytes.little(place, count);
  };
  constexpr std::uint64_t short_type = 3;
  const auto directory = static_cast<std::size_t>(value(4, 4));
  for (std::size_t i = 0; i < value(directory, 2); ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (value(entry, 2) == wanted) return value(entry + 8, value(entry + 2, 2) == short_type ? 2 : 4);
  }
  return std::nullopt;
}

std::optional<ImageSize> tiff_size(const Bytes& bytes, bool big) {
  constexpr std::uint64_t width_tag = 256, height_tag = 257;
  return ImageSize{tiff_value(bytes, big, width_tag).value_or(0), tiff_value(bytes, big, height_tag).value_or(0)};
}

/// P1 to P6: two numbers after comments; P7 and others are not read.
std::optional<ImageSize> pnm_size(std::string_view text) {
  text.remove_prefix(2);
  std::uint64_t values[2] = {};
  int found = 0;
  text = text.substr(0, 4096);
  for (std::string_view line; found < 2 && next_line(text, line);) {
    line = line.substr(0, line.find('#'));
    for (std::string_view word = next_word(line); found < 2 && !word.empty(); word = next_word(line)) {
      const std::optional<double> number = parse_number(word);
      if (!number || !(*number >= 0 && *number < 1e9)) return std::nullopt;
      values[found++] = static_cast<std::uint64_t>(*number);
    }
  }
  return found == 2 ? std::optional(ImageSize{values[0], values[1]}) : std::nullopt;
}

/// "-Y height +X width" on a line of its own.
std::optional<ImageSize> radiance_size(std::string_view text) {
  text = text.substr(0, 1 << 16);
  for (std::string_view line; next_line(text, line);) {
    const std::string_view first = next_word(line);
    if (first != "-Y" && first != "+Y") continue;
    const std::optional<double> height = parse_number(next_word(line));
    next_word(line);
    const std::optional<double> width = parse_number(next_word(line));
    if (!height || !width || !(*height >= 0 && *height < 1e9) || !(*width >= 0 && *width < 1e9)) return std::nullopt;
    return ImageSize{static_cast<std::uint64_t>(*width), static_cast<std::uint64_t>(*height)};
  }
  return std::nullopt;
}

std::optional<ImageSize> jpeg2000_size(std::string_view text) {
  const Bytes bytes(text);
  if (text.starts_with("\xff\x4f\xff\x51")) {  // a bare code stream: size less the image's offset in it
    return ImageSize{bytes.big(8, 4) - bytes.big(16, 4), bytes.big(12, 4) - bytes.big(20, 4)};
  }
  const std::size_t box = text.substr(0, 4096).find("ihdr");
  if (box == text.npos) return std::nullopt;
  return ImageSize{bytes.big(box + 8, 4), bytes.big(box + 4, 4)};
}

}  // namespace

std::optional<ImageSize> image_size(std::string_view text) {
  using namespace std::string_view_literals;
  const Bytes bytes(text);
  if (text.starts_with("\x89PNG")) return ImageSize{bytes.big(16, 4), bytes.big(20, 4)};
  if (text.starts_with("\xff\xd8")) return jpeg_size(bytes);
  if (text.starts_with("BM")) return bmp_size(bytes);
  if (text.size() >= 16 && text.starts_with("RIFF") && text.substr(8, 4) == "WEBP")
    return webp_size(bytes, text.substr(12, 4));
  if (text.starts_with("II*\0"sv)) return tiff_size(bytes, false);
  if (text.starts_with("MM\0*"sv)) return tiff_size(bytes, true);
  if (text.size() > 2 && text[0] == 'P' && text[1] >= '1' && text[1] <= '6') return pnm_size(text);
  if (text.starts_with("#?")) return radiance_size(text);
  if (text.starts_with("\0\0\0\x0cjP"sv) || text.starts_with("\xff\x4f\xff\x51")) return jpeg2000_size(text);
  return std::nullopt;
}

int jpeg_orientation(std::string_view text) {
  using namespace std::string_view_literals;
  const Bytes bytes(text);
  if (!text.starts_with("\xff\xd8")) return 1;
  for (std::size_t at = 2; at + 4 < text.size() && bytes.at(at) == 0xff && bytes.at(at + 1) != 0xda;) {
    const auto length = static_cast<std::size_t>(bytes.big(at + 2, 2));
    const std::string_view segment = text.substr(std::min(at + 4, text.size()), length);
    if (bytes.at(at + 1) == 0xe1 && segment.starts_with("Exif\0\0"sv)) {
      const std::string_view exif = segment.substr(6);
      const std::optional<std::uint64_t> value = tiff_value(Bytes(exif), exif.starts_with("MM"), 274);
      return value && *value >= 1 && *value <= 8 ? static_cast<int>(*value) : 1;
    }
    at += 2 + length;
  }
  return 1;
}

}  // namespace holdfast::io
