#include "profile.hpp"

#include <dlfcn.h>

#include <cstring>
#include <mutex>
#include <vector>

#include "shared.h"

namespace holdfast::bench {
namespace {

/// The calls so far. The functions below have the names of OpenCL's own and so are called in their place; the loader's
/// are found behind them. A table of the process, because functions with C's names have no other place for it.
struct Calls {
  struct Call {
    cl_kernel kernel;
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

}  // namespace

std::map<std::string, KernelFigures> take_profile(const cl::CommandQueue& queue) {
  queue.finish();
  std::map<std::string, KernelFigures> figures;
  const std::lock_guard lock(calls().mutex);
  for (const Calls::Call& call : calls().calls) {
    char name[128] = {};
    clGetKernelInfo(call.kernel, CL_KERNEL_FUNCTION_NAME, sizeof(name) - 1, name, nullptr);
    cl_ulong start = 0, end = 0;
    clGetEventProfilingInfo(call.event, CL_PROFILING_COMMAND_START, sizeof(start), &start, nullptr);
    clGetEventProfilingInfo(call.event, CL_PROFILING_COMMAND_END, sizeof(end), &end, nullptr);
    clReleaseEvent(call.event);
    KernelFigures& kernel = figures[name];
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
  cl_event own = nullptr;
  const cl_int error = real(queue, kernel, dimensions, offset, global, local, wait_count, wait_list, &own);
  if (error != CL_SUCCESS) return error;
  if (event != nullptr) {
    clRetainEvent(own);
    *event = own;
  }
  const std::lock_guard lock(bench::calls().mutex);
  double region = 0;
  if (const auto found = bench::calls().regions.find(kernel); found != bench::calls().regions.end()) {
    region = static_cast<double>(found->second.width) * found->second.height;
  }
  bench::calls().calls.push_back({kernel, own, region});
  return error;
}
}
