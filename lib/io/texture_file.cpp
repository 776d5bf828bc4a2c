#include "io/texture_file.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/image_header.hpp"
#include "io/png_chunks.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {

Texture texture_from_image(const cv::Mat& image, const std::string& name) {
  cv::Mat bytes;
  if (image.depth() == CV_8U) {
    bytes = image;
  } else if (image.depth() == CV_16U) {
    image.convertTo(bytes, CV_8U, 1.0 / 257.0);
  } else {
    throw Error(ErrorCode::file,
                fmt::format("image '{}' holds neither 8 nor 16 bit integers: convert it to PNG or JPEG", name));
  }
  Texture texture{image.cols, image.rows, std::vector<std::uint8_t>(image.total() * 4)};
  cv::Mat rgba(image.rows, image.cols, CV_8UC4, texture.rgba.data());
  switch (bytes.channels()) {
    case 1:
      cv::cvtColor(bytes, rgba, cv::COLOR_GRAY2RGBA);
      break;
    case 2: {
      const int grey_grey_grey_alpha[] = {0, 0, 0, 1, 0, 2, 1, 3};
      cv::mixChannels(&bytes, 1, &rgba, 1, grey_grey_grey_alpha, 4);
      break;
    }
    case 3:
      cv::cvtColor(bytes, rgba, cv::COLOR_BGR2RGBA);
      break;
    case 4:
      cv::cvtColor(bytes, rgba, cv::COLOR_BGRA2RGBA);
      break;
    default:
      throw Error(ErrorCode::file, fmt::format("image '{}' has {} channels: save it with 1 to 4 (grey, RGB or RGBA)",
                                               name, bytes.channels()));
  }
  return texture;
}

namespace {

constexpr std::size_t kMostImageBytes = std::size_t{1} << 29;
constexpr std::uint64_t kMostSide = 1 << 15;
constexpr std::uint64_t kMostPixels = 1 << 26;

/// Pixels that no JPEG holds in a byte: each block of 64 takes a bit at least.
constexpr std::uint64_t kMostPixelsInByte = 1024;

/// libpng and libjpeg write to stderr when a file is damaged, so that is looked for before they are asked.
bool is_damaged(std::string_view bytes, const ImageSize& size) {
  if (bytes.starts_with("\x89PNG")) return !is_whole_png(bytes);
  return bytes.starts_with("\xff\xd8") &&
         (bytes.rfind("\xff\xd9") == bytes.npos || size.width * size.height > kMostPixelsInByte * bytes.size());
}

Error damaged(const std::string& name) {
  return {ErrorCode::file, fmt::format("image '{}' cannot be decoded: it is damaged, or no PNG or JPEG file", name)};
}

}  // namespace

void check_image(const void* bytes, std::size_t size, const std::string& name) {
  const std::string_view text(static_cast<const char*>(bytes), size);
  const std::optional<ImageSize> shown = size > 0 ? image_size(text) : std::nullopt;
  if (!shown || shown->width == 0 || shown->height == 0) throw damaged(name);
  if (shown->width > kMostSide || shown->height > kMostSide || shown->width * shown->height > kMostPixels) {
    throw Error(
        ErrorCode::file,
        fmt::format("image '{}' is {}x{} pixels, more than 67 million or {} a side: scale it down, if it is not "
                    "damaged",
                    name, shown->width, shown->height, kMostSide));
  }
  if (is_damaged(text, *shown)) throw damaged(name);
}

int image_turn(const void* bytes, std::size_t size) {
  switch (jpeg_orientation({static_cast<const char*>(bytes), size})) {
    case 3:
    case 4:
      return 180;
    case 5:
    case 6:
      return 90;
    case 7:
    case 8:
      return 270;
    default:
      return 0;
  }
}

Texture decode_texture(const void* bytes, std::size_t size, const std::string& name) {
  cv::Mat image;
  try {
    check_image(bytes, size, name);
    const cv::Mat encoded(1, static_cast<int>(size), CV_8U, const_cast<void*>(bytes));
    image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();  // said below, in one line
  }
  if (image.empty()) throw damaged(name);
  return texture_from_image(image, name);
}

Texture load_texture(const std::filesystem::path& path) {
  const std::string bytes = read_binary_file(path, "image", kMostImageBytes);
  return decode_texture(bytes.data(), bytes.size(), path.string());
}

void save_texture(const std::filesystem::path& path, const Texture& texture) {
  cv::Mat bgra;
  const cv::Mat rgba(texture.height, texture.width, CV_8UC4, const_cast<std::uint8_t*>(texture.rgba.data()));
  cv::cvtColor(rgba, bgra, cv::COLOR_RGBA2BGRA);
  std::vector<std::uint8_t> encoded;
  if (!cv::imencode(".png", bgra, encoded)) {
    throw Error(ErrorCode::output, fmt::format("'{}' cannot be encoded as PNG", path.string()));
  }
  write_text_file(path, std::string(encoded.begin(), encoded.end()));
}

}  // namespace holdfast::io
