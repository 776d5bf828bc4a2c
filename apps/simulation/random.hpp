#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace holdfast::simulation {

/// One of 2^64 reproducible numbers: the same on every machine, compiler and number of threads, which the standard
/// library's distributions do not promise.
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0) {
  constexpr auto mix = [](std::uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  return mix(mix(mix(a + 0x9e3779b97f4a7c15ULL) + b + 0x9e3779b97f4a7c15ULL) + c + 0x9e3779b97f4a7c15ULL);
}

/// A stream of reproducible random numbers.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : seed_(hash(seed, stream)) {}

  std::uint64_t bits() { return hash(seed_, count_++); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in [0, count).
  int below(int count) { return static_cast<int>(uniform() * count); }
  /// Standard normal (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
};

}  // namespace holdfast::simulation
