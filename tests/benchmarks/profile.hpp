#pragma once

#include <map>
#include <string>

#include "device/opencl.hpp"

namespace holdfast::bench {

/// What a kernel, or copying to the device ("write") or from it ("read"), did since the last take_profile().
struct KernelFigures {
  int calls = 0;
  double milliseconds = 0;  ///< on the device, by its own clock
  double region = 0;        ///< width times height of the regions it was given: pixels, or tiles; bytes copied
};

/// Waits for the queue, which must have been made for profiling, and returns the figures of every kernel and copy that
/// this process has enqueued since the last call. The process's calls of OpenCL pass through profile.cpp for this.
std::map<std::string, KernelFigures> take_profile(const cl::CommandQueue& queue);

}  // namespace holdfast::bench
