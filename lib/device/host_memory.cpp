#include "device/host_memory.hpp"

#include <cstring>

namespace holdfast {

HostMemory::HostMemory(const cl::Context& context, const cl::CommandQueue& queue, std::size_t bytes, bool page_locked)
    : queue_(queue) {
  if (page_locked) {
    // OpenCL's only way to such memory: what a buffer of this kind is mapped to.
    locked_ = cl::Buffer(context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes);
    data_ = queue_.enqueueMapBuffer(locked_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes);
    std::memset(data_, 0, bytes);
  } else {
    heap_.resize(bytes);
    data_ = heap_.data();
  }
}

HostMemory::~HostMemory() {
  try {
    if (locked_() != nullptr) queue_.enqueueUnmapMemObject(locked_, data_);
    queue_.finish();  // what still copies must not find it gone
  } catch (const cl::Error&) {
    // A device that failed: nothing is left to be undone.
  }
}

}  // namespace holdfast
