#pragma once

#include <cstddef>
#include <vector>

#include "device/opencl.hpp"

namespace holdfast {

/// Memory of the host that a device copies from or to, all zeros at first. Page-locked, its driver copies straight from
/// or to it while the host goes on; otherwise a device with memory of its own needs a copy in between.
class HostMemory {
 public:
  /// Throws cl::Error.
  HostMemory(const cl::Context& context, const cl::CommandQueue& queue, std::size_t bytes, bool page_locked);
  ~HostMemory();
  HostMemory(const HostMemory&) = delete;
  HostMemory& operator=(const HostMemory&) = delete;

  void* data() const { return data_; }
  template <typename T>
  T* as() const {
    return static_cast<T*>(data_);
  }

 private:
  cl::CommandQueue queue_;
  cl::Buffer locked_;  ///< mapped as long as this lives; null where the heap's does
  std::vector<std::byte> heap_;
  void* data_;
};

}  // namespace holdfast
