#pragma once

#include <cstddef>

#include "device/opencl.hpp"

namespace holdfast::bench {

/// The device that Holdfast would choose.
cl::Device chosen_device();

/// What the device can do at best, by kernels that do one thing each. A call enqueues one, or as many as make
/// the waiting for them small, and waits.
class DeviceLimits {
 public:
  DeviceLimits();

  /// Copies within two buffers of `bytes`, which the first call of that size allocates and fills.
  void copy(std::size_t bytes);
  /// Bytes that such a call reads and writes.
  double copied(std::size_t bytes) const;
  void multiply_add();
  /// Floating-point operations of a multiply_add(), a multiply-add counting as two.
  double operations() const;

 private:
  void enqueue(const cl::Kernel& kernel, std::size_t items) const;

  bool wide_;  // vectors are a work-item's, otherwise a group's
  int launches_;
  std::size_t items_;
  cl::Context context_;
  cl::CommandQueue queue_;
  cl::Kernel copy_, multiply_add_;
  cl::Buffer in_, out_, sums_;
  std::size_t bytes_ = 0;
};

}  // namespace holdfast::bench
