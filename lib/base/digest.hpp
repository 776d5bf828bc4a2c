#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace holdfast {

/// 128 bits of hash as text: FNV-1a of 64 bits from two seeds, over words of four bytes, a rest byte by byte.
class Digest {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    std::size_t i = 0;
    for (; i + 4 <= size; i += 4) {
      std::uint32_t word;
      std::memcpy(&word, bytes + i, 4);
      add_word(word);
    }
    for (; i < size; ++i) add_word(bytes[i]);
    add_word(static_cast<std::uint32_t>(size));
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.data(), values.size() * sizeof(T));
  }
  std::string text() const {
    std::array<char, 40> name;
    std::snprintf(name.data(), name.size(), "%016llx%016llx", static_cast<unsigned long long>(first_),
                  static_cast<unsigned long long>(second_));
    return name.data();
  }

 private:
  void add_word(std::uint32_t word) {
    constexpr std::uint64_t prime = 1099511628211ull;
    first_ = (first_ ^ word) * prime;
    first_ ^= first_ >> 32;
    second_ = (second_ ^ word) * prime;
    second_ ^= second_ >> 29;
  }
  std::uint64_t first_ = 14695981039346656037ull, second_ = 1469598103934665603ull;
};

}  // namespace holdfast
