#include "support/kernel_checks.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>

namespace holdfast::test {
namespace {

using reference::Planes;

std::vector<Partition> partitions() {
  const char* only = std::getenv("HOLDFAST_TEST_PARTITION");
  if (only == nullptr) return {Partition::strips, Partition::groups};
  REQUIRE(std::string(only) == "groups");
  return {Partition::groups};
}

void check_sizes(KernelCheck check, const std::vector<Size>& sizes) {
  for (const Partition partition : partitions()) {
    CAPTURE(static_cast<int>(partition));
    DeviceOptions options;
    options.partition = partition;
    const Device device(options);
    for (const Size size : sizes) {
      CAPTURE(size.width);
      check(device.impl(), size);
    }
  }
}

}  // namespace

void check_small(KernelCheck check) { check_sizes(check, {{1, 1}, {17, 13}}); }
void check_large(KernelCheck check) { check_sizes(check, {{640, 480}}); }

Level level_of(Size size) {
  Camera camera{size.width,        size.height, 1.1 * size.width + 3, 0.9 * size.width + 5, 0.4 * size.width,
                0.6 * size.height, {}};
  return make_levels(camera, 1)[0];
}

Planes random_pixels(Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes planes(size.width, size.height, 4);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double draw = uniform(random);
      const double coverage = draw < 0.2 ? 0 : draw < 0.8 ? 1 : uniform(random);
      for (int c = 0; c < 3; ++c) planes.at(x, y, c) = static_cast<float>(coverage * uniform(random));
      planes.at(x, y, 3) = static_cast<float>(coverage);
    }
  }
  return planes;
}

reference::Planes two_colors(Size size, const Eigen::Vector2d& normal, const Eigen::Vector2d& middle,
                             const Eigen::Vector3d& before, const Eigen::Vector3d& beyond) {
  constexpr int kFine = 8;
  reference::Planes frame(size.width, size.height, HF_PIXEL);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      int hits = 0;
      for (int n = 0; n < kFine * kFine; ++n) {
        const Eigen::Vector2d at(x + (n % kFine + 0.5) / kFine - 0.5, y + (n / kFine + 0.5) / kFine - 0.5);
        hits += normal.dot(at - middle) < 0 ? 1 : 0;
      }
      const double share = static_cast<double>(hits) / (kFine * kFine);
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = as_float(share * before(c) + (1 - share) * beyond(c));
      frame.at(x, y, 3) = 1;
    }
  }
  return frame;
}

std::vector<float> to_memory(const Planes& planes, const Level& level) {
  const auto channels = static_cast<std::size_t>(planes.channels);
  std::vector<float> memory((level.elements + kGuardFloats) * channels, 0.0f);
  for (int y = 0; y < planes.height; ++y) {
    for (int x = 0; x < planes.width; ++x) {
      const auto e = element(level, x, y);
      for (int c = 0; c < planes.channels; ++c) {
        memory[e * channels + static_cast<std::size_t>(c)] = static_cast<float>(planes.get(x, y, c));
      }
    }
  }
  return memory;
}

std::vector<float> to_plane_memory(const Planes& planes, const Level& level) {
  std::vector<float> memory(level.elements * static_cast<std::size_t>(planes.channels) + kGuardFloats, 0.0f);
  for (int y = 0; y < planes.height; ++y) {
    for (int x = 0; x < planes.width; ++x) {
      const auto e = element(level, x, y);
      for (int c = 0; c < planes.channels; ++c) {
        memory[e + static_cast<std::size_t>(c) * level.elements] = static_cast<float>(planes.get(x, y, c));
      }
    }
  }
  return memory;
}

double largest_difference(const std::vector<float>& memory, const Level& level, const Planes& expected) {
  double largest = 0;
  for (int y = 0; y < expected.height; ++y) {
    for (int x = 0; x < expected.width; ++x) {
      const auto e = element(level, x, y);
      for (int c = 0; c < expected.channels; ++c) {
        const auto i = e * static_cast<std::size_t>(expected.channels) + static_cast<std::size_t>(c);
        largest = std::max(largest, std::abs(static_cast<double>(memory[i]) - expected.get(x, y, c)));
      }
    }
  }
  return largest;
}

}  // namespace holdfast::test
