#include "io/png_chunks.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace holdfast::io {
namespace {

/// A byte's share of the sum when so many bytes follow it: eight bytes are added at once, as frames are checked too.
using SumTables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr SumTables sum_tables() {
  SumTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t sum = byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? 0xedb88320U ^ sum >> 1 : sum >> 1;
    tables[0][byte] = sum;
  }
  for (std::size_t i = 1; i < tables.size(); ++i) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t sum = tables[i - 1][byte];
      tables[i][byte] = tables[0][sum & 0xff] ^ sum >> 8;
    }
  }
  return tables;
}

constexpr SumTables kTables = sum_tables();

std::uint32_t byte_at(std::string_view bytes, std::size_t at) { return static_cast<unsigned char>(bytes[at]); }

std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 | byte_at(bytes, at + 2) << 16 | byte_at(bytes, at + 3) << 24;
}

/// The CRC of PNG (and zlib).
std::uint32_t checksum(std::string_view bytes) {
  std::uint32_t sum = ~0U;
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    const std::uint32_t first = sum ^ little_endian(bytes, at), second = little_endian(bytes, at + 4);
    sum = kTables[7][first & 0xff] ^ kTables[6][first >> 8 & 0xff] ^ kTables[5][first >> 16 & 0xff] ^
          kTables[4][first >> 24] ^ kTables[3][second & 0xff] ^ kTables[2][second >> 8 & 0xff] ^
          kTables[1][second >> 16 & 0xff] ^ kTables[0][second >> 24];
  }
  for (; at < bytes.size(); ++at) sum = kTables[0][(byte_at(bytes, at) ^ sum) & 0xff] ^ sum >> 8;
  return ~sum;
}

std::uint32_t big_endian(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 24 | byte_at(bytes, at + 1) << 16 | byte_at(bytes, at + 2) << 8 | byte_at(bytes, at + 3);
}

}  // namespace

bool is_whole_png(std::string_view bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {  // length, name, data, sum
    const std::size_t length = big_endian(bytes, at);
    if (length > bytes.size() - at - 12) return false;
    const std::string_view name = bytes.substr(at + 4, 4);
    const bool needed = name[0] >= 'A' && name[0] <= 'Z';
    if (needed && checksum(bytes.substr(at + 4, length + 4)) != big_endian(bytes, at + 8 + length)) return false;
    if (name == "IEND") return true;
    at += 12 + length;
  }
  return false;
}

}  // namespace holdfast::io
