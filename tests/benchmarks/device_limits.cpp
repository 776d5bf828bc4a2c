#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "benchmarks.hpp"
#include "holdfast/device.hpp"
#include "opencl.hpp"

namespace holdfast::bench {
namespace {

constexpr int kChains = 12;    // independent sums: more than a multiply-add unit's latency
constexpr int kRounds = 4096;  // of all chains, a work-item
constexpr int kItems = 64;     // work-items
constexpr int kLanes = 16;     // floats of a vector

const char* const kSource = R"(
__kernel void copy(__global const float16* in, __global float16* out) {
  const size_t begin = get_global_id(0) * 256;
  for (size_t i = begin; i < begin + 256; ++i) out[i] = in[i];
}
__kernel void multiply_add(float seed, int rounds, __global float16* out) {
  const float16 a = (float16)(seed), b = (float16)(1.0f - seed);
  float16 s0 = b, s1 = b + 1.0f, s2 = b + 2.0f, s3 = b + 3.0f, s4 = b + 4.0f, s5 = b + 5.0f, s6 = b + 6.0f,
          s7 = b + 7.0f, s8 = b + 8.0f, s9 = b + 9.0f, s10 = b + 10.0f, s11 = b + 11.0f;
  for (int i = 0; i < rounds; ++i) {
    s0 = fma(s0, a, b); s1 = fma(s1, a, b); s2 = fma(s2, a, b); s3 = fma(s3, a, b);
    s4 = fma(s4, a, b); s5 = fma(s5, a, b); s6 = fma(s6, a, b); s7 = fma(s7, a, b);
    s8 = fma(s8, a, b); s9 = fma(s9, a, b); s10 = fma(s10, a, b); s11 = fma(s11, a, b);
  }
  out[get_global_id(0)] = s0 + s1 + s2 + s3 + s4 + s5 + s6 + s7 + s8 + s9 + s10 + s11;
}
)";

/// The device that Holdfast would choose, with kernels that do one thing each.
struct Limits {
  Limits() {
    const DeviceInfo info = Device().info();
    std::vector<cl::Platform> platforms;
    cl::Platform::get(&platforms);
    std::vector<cl::Device> devices;
    platforms.at(static_cast<std::size_t>(info.platform_index)).getDevices(CL_DEVICE_TYPE_ALL, &devices);
    const cl::Device device = devices.at(static_cast<std::size_t>(info.device_index));
    context = cl::Context(device);
    queue = cl::CommandQueue(context, device);
    program = cl::Program(context, kSource, true);
  }
  cl::Context context;
  cl::CommandQueue queue;
  cl::Program program;
};

using SharedLimits = std::shared_ptr<std::unique_ptr<Limits>>;

Limits& made(const SharedLimits& limits) {
  if (!*limits) *limits = std::make_unique<Limits>();
  return **limits;
}

void copy(benchmark::State& state, Limits& limits, std::size_t bytes) {
  const cl::Buffer in(limits.context, CL_MEM_READ_ONLY, bytes), out(limits.context, CL_MEM_WRITE_ONLY, bytes);
  limits.queue.enqueueFillBuffer(in, 0.5f, 0, bytes);
  limits.queue.enqueueFillBuffer(out, 0.5f, 0, bytes);
  cl::Kernel kernel(limits.program, "copy");
  kernel.setArg(0, in);
  kernel.setArg(1, out);
  const std::size_t items = bytes / (256 * kLanes * sizeof(float));
  for (auto _ : state) {
    limits.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(1));
    limits.queue.finish();
  }
  // Read and written.
  state.counters["GB_per_s"] =
      benchmark::Counter(2e-9 * static_cast<double>(bytes), benchmark::Counter::kIsIterationInvariantRate);
}

void multiply_add(benchmark::State& state, Limits& limits) {
  const cl::Buffer out(limits.context, CL_MEM_WRITE_ONLY, kItems * kLanes * sizeof(float));
  cl::Kernel kernel(limits.program, "multiply_add");
  kernel.setArg(0, 0.25f);
  kernel.setArg(1, kRounds);
  kernel.setArg(2, out);
  for (auto _ : state) {
    limits.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(kItems), cl::NDRange(1));
    limits.queue.finish();
  }
  const double operations = 2.0 * kLanes * kChains * kRounds * kItems;
  state.counters["GFLOP_per_s"] = benchmark::Counter(1e-9 * operations, benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

void register_device_limits() {
  const auto limits = std::make_shared<std::unique_ptr<Limits>>();
  for (const std::size_t kilobytes : {512, 65536}) {  // within the caches, and from memory
    benchmark::RegisterBenchmark(
        ("limit/copy/" + std::to_string(kilobytes)).c_str(),
        [limits, kilobytes](benchmark::State& state) { copy(state, made(limits), 1024 * kilobytes); })
        ->UseRealTime()
        ->MeasureProcessCPUTime()
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("limit/multiply_add",
                               [limits](benchmark::State& state) { multiply_add(state, made(limits)); })
      ->UseRealTime()
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace holdfast::bench
