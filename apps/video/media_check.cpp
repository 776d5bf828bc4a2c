#include "video/media_check.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

namespace holdfast::app {
namespace {

std::uint64_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) {
    value = value << 8 | bytes[i];
  }
  return value;
}

std::string_view tag(const std::uint8_t* bytes) { return {reinterpret_cast<const char*>(bytes), 4}; }

bool read_at(std::ifstream& file, std::uint64_t offset, std::uint8_t* bytes, std::size_t count) {
  file.clear();
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(count));
  return static_cast<std::size_t>(file.gcount()) == count;
}

std::string cut_short(std::uint64_t size, std::uint64_t wanted) {
  return fmt::format("it is cut short: {} of {} bytes", size, wanted);
}

/// Walks the top-level boxes of an MP4 or MOV file.
std::optional<std::string> mp4_damage(std::ifstream& file, std::uint64_t size) {
  bool has_index = false;
  std::uint64_t offset = 0;
  std::array<std::uint8_t, 16> header{};
  while (offset + 8 <= size) {
    if (!read_at(file, offset, header.data(), 8)) {
      return std::nullopt;
    }
    std::uint64_t length = big_endian(header.data(), 4);
    has_index = has_index || tag(&header[4]) == "moov";
    if (length == 0) {  // reaches to the end of the file
      length = size - offset;
    } else if (length == 1) {  // 64 bit follow
      if (!read_at(file, offset, header.data(), header.size())) {
        return cut_short(size, offset + header.size());
      }
      length = big_endian(&header[8], 8);
    }
    if (length < 8) {
      return fmt::format("its structure is broken at byte {}", offset);
    }
    if (length > size - offset) {
      return cut_short(size, offset + length);
    }
    offset += length;
  }
  if (!has_index) {
    return "its index is missing: the recording was not finished, or the file is cut short";
  }
  return std::nullopt;
}

std::optional<std::string> riff_damage(const std::uint8_t* header, std::uint64_t size) {
  std::uint64_t length = 0;
  for (int i = 3; i >= 0; --i) {
    length = length << 8 | header[4 + i];
  }
  if (length == 0) {
    return "its header was never completed: the recording was not finished";
  }
  return length + 8 > size ? std::optional(cut_short(size, length + 8)) : std::nullopt;
}

/// A number of EBML: the zeros before its first bit tell how many bytes follow. Nothing for an unknown size.
std::optional<std::uint64_t> ebml_size(const std::uint8_t* bytes, std::size_t& length) {
  length = 1 + static_cast<std::size_t>(std::countl_zero(bytes[0]));
  if (length > 8) return std::nullopt;
  const std::uint64_t most = (std::uint64_t{1} << (7 * length)) - 1;
  const std::uint64_t value = big_endian(bytes, static_cast<int>(length)) & most;
  return value == most ? std::nullopt : std::optional(value);
}

/// MKV and WebM: a head, then one segment, which knows its size once the recording was finished.
std::optional<std::string> matroska_damage(std::ifstream& file, std::uint64_t size) {
  constexpr std::size_t id = 4;
  std::array<std::uint8_t, 16> bytes{};
  std::size_t length = 0;
  if (!read_at(file, 0, bytes.data(), bytes.size())) return std::nullopt;
  const std::optional<std::uint64_t> head = ebml_size(&bytes[id], length);
  if (!head) return std::nullopt;
  const std::uint64_t segment = id + length + *head;
  if (segment > size || !read_at(file, segment, bytes.data(), id + 8)) return std::nullopt;
  const std::optional<std::uint64_t> content = ebml_size(&bytes[id], length);
  const bool is_segment = big_endian(bytes.data(), static_cast<int>(id)) == 0x18538067;
  if (!is_segment || !content || segment + id + length + *content <= size) return std::nullopt;
  return cut_short(size, segment + id + length + *content);
}

std::optional<std::string> jpeg_damage(std::span<const std::uint8_t> bytes) {
  // Segments with a length, up to the first scan: a thumbnail among them has an end mark of its own.
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && bytes[at] == 0xff && bytes[at + 1] != 0xda) {
    at += bytes[at + 1] == 0xff ? 1 : 2 + static_cast<std::size_t>(big_endian(&bytes[at + 2], 2));
  }
  for (; at + 1 < bytes.size(); ++at) {
    if (bytes[at] == 0xff && bytes[at + 1] == 0xd9) {
      return std::nullopt;
    }
  }
  return "it is cut short: the JPEG has no end mark";
}

std::optional<std::string> png_damage(std::span<const std::uint8_t> bytes) {
  std::uint64_t at = 8;
  while (at + 12 <= bytes.size()) {  // chunks: length, name, data, checksum
    if (tag(&bytes[at + 4]) == "IEND") {
      return std::nullopt;
    }
    at += 12 + big_endian(&bytes[at], 4);
  }
  return "it is cut short: the PNG has no end mark";
}

/// The place and length of what a box of this name holds, looked for among the boxes from `begin` to `end`.
std::optional<std::pair<std::uint64_t, std::uint64_t>> find_box(std::ifstream& file, std::uint64_t begin,
                                                                std::uint64_t end, std::string_view name) {
  std::array<std::uint8_t, 16> header{};
  while (begin + 8 <= end && read_at(file, begin, header.data(), 8)) {
    std::uint64_t length = big_endian(header.data(), 4), head = 8;
    const bool found = tag(&header[4]) == name;
    if (length == 1 && read_at(file, begin, header.data(), header.size())) {
      length = big_endian(&header[8], 8);
      head = 16;
    }
    length = length == 0 ? end - begin : length;
    if (length < head || length > end - begin) break;
    if (found) return std::pair{begin + head, length - head};
    begin += length;
  }
  return std::nullopt;
}

/// How long an MP4 or MOV file says that it plays, edit lists applied.
std::optional<double> mp4_duration(std::ifstream& file, std::uint64_t size) {
  const auto movie = find_box(file, 0, size, "moov");
  const auto header = movie ? find_box(file, movie->first, movie->first + movie->second, "mvhd") : std::nullopt;
  std::array<std::uint8_t, 32> bytes{};
  if (!header || header->second < bytes.size() || !read_at(file, header->first, bytes.data(), bytes.size())) {
    return std::nullopt;
  }
  const bool wide = bytes[0] == 1;
  const std::uint64_t scale = big_endian(&bytes[wide ? 20 : 12], 4),
                      length = big_endian(&bytes[wide ? 24 : 16], wide ? 8 : 4);
  return scale > 0 && length > 0 ? std::optional(static_cast<double>(length) / static_cast<double>(scale))
                                 : std::nullopt;
}

}  // namespace

CountPromise count_promise(const std::filesystem::path& path) {
  std::error_code failed;
  const std::uint64_t size =
      std::filesystem::is_regular_file(path, failed) ? std::filesystem::file_size(path, failed) : 0;
  std::ifstream file(path, std::ios::binary);
  std::array<std::uint8_t, 12> header{};
  if (failed || size == 0 || !file || !read_at(file, 0, header.data(), header.size())) {
    return {};
  }
  if (tag(&header[4]) == "ftyp") {
    return {true, mp4_duration(file, size)};
  }
  return {tag(header.data()) == "RIFF" && tag(&header[8]) == "AVI ", std::nullopt};
}

std::optional<std::string> video_damage(const std::filesystem::path& path) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) {
    return std::nullopt;
  }
  const std::uint64_t size = std::filesystem::file_size(path, failed);
  std::ifstream file(path, std::ios::binary);
  std::array<std::uint8_t, 12> header{};
  if (size == 0) {
    return "it is empty";
  }
  if (failed || !file || !read_at(file, 0, header.data(), header.size())) {
    return std::nullopt;
  }
  if (tag(&header[4]) == "ftyp") {
    return mp4_damage(file, size);
  }
  if (tag(header.data()) == "RIFF" && tag(&header[8]) == "AVI ") {
    return riff_damage(header.data(), size);
  }
  if (big_endian(header.data(), 4) == 0x1a45dfa3) {
    return matroska_damage(file, size);
  }
  return std::nullopt;
}

bool is_recording(const std::filesystem::path& path) {
  std::error_code failed;
  std::ifstream file(path, std::ios::binary);
  std::array<std::uint8_t, 12> header{};
  if (!std::filesystem::is_regular_file(path, failed) || !read_at(file, 0, header.data(), header.size())) return false;
  return tag(&header[4]) == "ftyp" || tag(header.data()) == "RIFF" || tag(header.data()) == "OggS" ||
         big_endian(header.data(), 4) == 0x1a45dfa3;
}

std::optional<std::string> image_damage(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= 4 && bytes[0] == 0xff && bytes[1] == 0xd8) {
    return jpeg_damage(bytes);
  }
  if (bytes.size() >= 8 && tag(bytes.data()) == std::string_view("\x89PNG")) {
    return png_damage(bytes);
  }
  return std::nullopt;
}

}  // namespace holdfast::app
