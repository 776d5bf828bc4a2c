#pragma once

#include <future>
#include <string>
#include <utility>

#include "device/host_memory.hpp"
#include "device/opencl.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"

namespace holdfast {

struct Device::Impl {
  cl::Context context;
  cl::Device device;
  cl::CommandQueue queue;
  std::shared_future<cl::Program> program;  ///< being loaded, or compiled, beside what else is prepared
  DeviceInfo info;
  RendererChoice renderer = RendererChoice::automatic;
  bool strips = true;  ///< partition: one work-item a row or tile (CPU devices)

  /// Waits for the program. Throws Error(device) with the compiler's log when it does not compile.
  cl::Kernel kernel(const char* name) const { return cl::Kernel(program.get(), name); }

  /// A zeroed buffer. Allocation counts as construction: never called in the per-frame path.
  cl::Buffer zeroed_buffer(std::size_t bytes) const;

  /// For copies to and from this device; as zeroed_buffer().
  HostMemory host_memory(std::size_t bytes) const;

  /// Enqueues an image kernel over `width` x `height` pixels: an item a row, or an item a pixel.
  void enqueue_rows(const cl::Kernel& kernel, int width, int height) const;

  /// Enqueues a kernel of at least so many items.
  void enqueue_items(const cl::Kernel& kernel, std::size_t count) const;

  /// Enqueues a kernel over tiles: an item, or a group, a tile.
  void enqueue_tiles(const cl::Kernel& kernel, int tiles_x, int tiles_y) const;
};

/// Sets all arguments of a kernel, in its order. Buffers must live until it is enqueued: arguments do not retain them.
template <typename... Arguments>
void set_arguments(cl::Kernel& kernel, const Arguments&... arguments) {
  cl_uint index = 0;
  (kernel.setArg(index++, arguments), ...);
}

/// Calls `action`, turning OpenCL's exceptions into Error(device) that names what was being done.
template <typename Action>
auto with_device_errors(const char* doing, Action&& action) {
  try {
    return std::forward<Action>(action)();
  } catch (const cl::Error& error) {
    throw Error(ErrorCode::device, std::string("OpenCL failed while ") + doing + ": " + error.what() + " returned " +
                                       std::to_string(error.err()) + "; try another device (see 'holdfast devices')");
  }
}

}  // namespace holdfast
