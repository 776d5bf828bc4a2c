#include "profile.hpp"

#include <dlfcn.h>

#include <cstring>
#include <mutex>
#include <vector>

#include "device/shared.h"

namespace holdfast::bench {
namespace {

/// The calls so far. The functions below have the names of OpenCL's own and so are called in their place; the loader's
/// are found behind them. A table of the process, because functions with C's names have no other place for it.
struct Calls {
  struct Call {
    cl_kernel kernel;  // or null, for a copy:
    const char* copy;
    cl_event event;
    double region;
  };
  std::mutex mutex;
  std::map<cl_kernel, kernel::hf_rect> regions;
  std::map<cl_kernel, cl_uint> region_arguments;  // the first that can be a region, in every kernel
  std::vector<Call> calls;
};

Calls& calls() {
  static Calls calls;
  return calls;
}

/// Other arguments of the same size are parameters with floats among them, whose bits make absurd sizes.
bool can_be_region(const kernel::hf_rect& rect) {
  constexpr int kMost = 1 << 15;
  return rect.width >= 0 && rect.height >= 0 && rect.width <= kMost && rect.height <= kMost;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Enqueues what `enqueue` does with an event, hands that to the caller if it wants it, and keeps it.
template <typename Enqueue>
cl_int keep(cl_event* event, cl_kernel kernel, const char* copy, double bytes, const Enqueue& enqueue) {
  cl_event own = nullptr;
  const cl_int error = enqueue(&own);
  if (error != CL_SUCCESS) return error;
  if (event != nullptr) {
    clRetainEvent(own);
    *event = own;
  }
  const std::lock_guard lock(calls().mutex);
  double region = bytes;
  if (const auto found = calls().regions.find(kernel); found != calls().regions.end()) {
    region = static_cast<double>(found->second.width) * found->second.height;
  }
  calls().calls.push_back({kernel, copy, own, region});
  return error;
}

double volume(const size_t* region) {
  return static_cast<double>(region[0]) * static_cast<double>(region[1]) * static_cast<double>(region[2]);
}

}  // namespace

std::map<std::string, KernelFigures> take_profile(const cl::CommandQueue& queue) {
  queue.finish();
  std::map<std::string, KernelFigures> figures;
  const std::lock_guard lock(calls().mutex);
  for (const Calls::Call& call : calls().calls) {
    char name[128] = {};
    if (call.kernel != nullptr) clGetKernelInfo(call.kernel, CL_KERNEL_FUNCTION_NAME, sizeof(name) - 1, name, nullptr);
    cl_ulong start = 0, end = 0;
    clGetEventProfilingInfo(call.event, CL_PROFILING_COMMAND_START, sizeof(start), &start, nullptr);
    clGetEventProfilingInfo(call.event, CL_PROFILING_COMMAND_END, sizeof(end), &end, nullptr);
    clReleaseEvent(call.event);
    KernelFigures& kernel = figures[call.kernel != nullptr ? name : call.copy];
    ++kernel.calls;
    kernel.milliseconds += 1e-6 * static_cast<double>(end - start);
    kernel.region += call.region;
  }
  calls().calls.clear();
  return figures;
}

}  // namespace holdfast::bench

extern "C" {

CL_API_ENTRY cl_int CL_API_CALL clSetKernelArg(cl_kernel kernel, cl_uint index, size_t size, const void* value) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clSetKernelArg)>("clSetKernelArg");
  if (size == sizeof(kernel::hf_rect) && value != nullptr) {
    kernel::hf_rect rect;
    std::memcpy(&rect, value, size);
    const std::lock_guard lock(bench::calls().mutex);
    if (bench::can_be_region(rect)) {
      const auto [argument, fresh] = bench::calls().region_arguments.try_emplace(kernel, index);
      if (index <= argument->second) {
        argument->second = index;
        bench::calls().regions[kernel] = rect;
      }
    }
  }
  return real(kernel, index, size, value);
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                                                       const size_t* offset, const size_t* global, const size_t* local,
                                                       cl_uint wait_count, const cl_event* wait_list, cl_event* event) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clEnqueueNDRangeKernel)>("clEnqueueNDRangeKernel");
  return bench::keep(event, kernel, nullptr, 0, [&](cl_event* own) {
    return real(queue, kernel, dimensions, offset, global, local, wait_count, wait_list, own);
  });
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                                     size_t offset, size_t size, const void* from, cl_uint wait_count,
                                                     const cl_event* wait_list, cl_event* event) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clEnqueueWriteBuffer)>("clEnqueueWriteBuffer");
  return bench::keep(event, nullptr, "write", static_cast<double>(size), [&](cl_event* own) {
    return real(queue, buffer, blocking, offset, size, from, wait_count, wait_list, own);
  });
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                                    size_t offset, size_t size, void* to, cl_uint wait_count,
                                                    const cl_event* wait_list, cl_event* event) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clEnqueueReadBuffer)>("clEnqueueReadBuffer");
  return bench::keep(event, nullptr, "read", static_cast<double>(size), [&](cl_event* own) {
    return real(queue, buffer, blocking, offset, size, to, wait_count, wait_list, own);
  });
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueWriteBufferRect(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                                         const size_t* origin, const size_t* host_origin,
                                                         const size_t* region, size_t row, size_t slice,
                                                         size_t host_row, size_t host_slice, const void* from,
                                                         cl_uint wait_count, const cl_event* wait_list,
                                                         cl_event* event) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clEnqueueWriteBufferRect)>("clEnqueueWriteBufferRect");
  return bench::keep(event, nullptr, "write", bench::volume(region), [&](cl_event* own) {
    return real(queue, buffer, blocking, origin, host_origin, region, row, slice, host_row, host_slice, from,
                wait_count, wait_list, own);
  });
}

CL_API_ENTRY cl_int CL_API_CALL clEnqueueReadBufferRect(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                                        const size_t* origin, const size_t* host_origin,
                                                        const size_t* region, size_t row, size_t slice, size_t host_row,
                                                        size_t host_slice, void* to, cl_uint wait_count,
                                                        const cl_event* wait_list, cl_event* event) {
  using namespace holdfast;
  static const auto real = bench::next<decltype(&clEnqueueReadBufferRect)>("clEnqueueReadBufferRect");
  return bench::keep(event, nullptr, "read", bench::volume(region), [&](cl_event* own) {
    return real(queue, buffer, blocking, origin, host_origin, region, row, slice, host_row, host_slice, to, wait_count,
                wait_list, own);
  });
}
}
