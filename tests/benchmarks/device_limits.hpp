#pragma once

#include <cstddef>

#include "opencl.hpp"

namespace holdfast::bench {

/// The device that Holdfast would choose.
cl::Device chosen_device();

/// What the device can do at best, by kernels that do one thing each. Every call enqueues one and waits for it.
class DeviceLimits {
 public:
  DeviceLimits();

  /// Copies within two buffers of `bytes`, which the first call of that size allocates and fills.
  void copy(std::size_t bytes);
  void multiply_add();
  /// Floating-point operations of a multiply_add(), a multiply-add counting as two.
  static double operations();

 private:
  cl::Context context_;
  cl::CommandQueue queue_;
  cl::Kernel copy_, multiply_add_;
  cl::Buffer in_, out_, sums_;
  std::size_t bytes_ = 0;
};

}  // namespace holdfast::bench
