#pragma once

#include <cstdint>
#include <vector>

#include "support/kernel_checks.hpp"

namespace holdfast::test {

/// Everything that the tests and the constraints read, random but plausible.
struct Scene {
  Scene(Size size, unsigned seed);

  std::uint8_t state(int x, int y) const { return usable[element(level, x, y)]; }

  Size size;
  Level level;
  reference::Planes value, dx, dy, depth;  ///< the view's
  reference::Planes frame, features;       ///< the frame, and its values and central differences
  reference::Planes cells;                 ///< gains and biases
  std::vector<std::uint8_t> usable;
  kernel::hf_rect tiles{};
  reference::Camera camera{};
};

/// By a few pixels, or (`scale` small) by so little that random gradients still agree.
kernel::hf_warp small_warp(const Scene& scene, double scale);

/// The scene in the device's memory, and the kernels that read it. Both outlive this.
class SceneOnDevice {
 public:
  SceneOnDevice(const Device::Impl& device, const Scene& scene);

  /// What the tests write of a pixel that they do not look at.
  static constexpr int kUntouched = 15;
  /// So that what is not written shows.
  void clear() const;

  void run_tests(const kernel::hf_warp& warp, const kernel::hf_tests& tests) const;
  std::vector<std::uint8_t> classes() const;
  std::vector<float> samples() const;

  /// Sums of every tile, from what the tests wrote.
  std::vector<float> run_constraints(const kernel::hf_constraints& constraints) const;
  std::vector<std::uint8_t> final_classes() const;

  /// Agreement of the view with the frame at each of `shifts`, from every `step`th pixel and row.
  std::vector<float> run_shift_scores(const Rect& shifts, int step) const;

 private:
  const Device::Impl& device_;
  const Scene& scene_;
  std::size_t sums_count_;
  cl::Buffer value_, dx_, dy_, depth_, usable_, frame_, cells_;
  cl::Buffer samples_, classes_, final_classes_, sums_;
};

}  // namespace holdfast::test
