#include "device_limits.hpp"

#include <vector>

#include "holdfast/device.hpp"

namespace holdfast::bench {
namespace {

constexpr int kChains = 12;    // independent sums: more than a multiply-add unit's latency
constexpr int kRounds = 4096;  // of all chains, a work-item
constexpr int kItems = 64;     // work-items
constexpr int kLanes = 16;     // floats of a vector
// On devices whose lanes are work-items:
constexpr int kGroup = 64;           // of items, as the tracker's kernels have
constexpr int kItemsAUnit = 2048;    // as many as a compute unit may hold
constexpr int kGroupLaunches = 100;  // a launch takes longer than copying 4 MB

/// WIDE: an item copies a block of its own with wide vectors. Otherwise neighbouring items take neighbouring elements.
const char* const kSource = R"(
#if WIDE
typedef float16 copied, summed;
#define ELEMENTS 256
#else
typedef float4 copied;
typedef float summed;
#define ELEMENTS 1
#endif
__kernel void copy(__global const copied* in, __global copied* out) {
  const size_t begin = get_global_id(0) * ELEMENTS;
  for (size_t i = begin; i < begin + ELEMENTS; ++i) out[i] = in[i];
}
__kernel void multiply_add(float seed, int rounds, __global summed* out) {
  const summed a = (summed)(seed), b = (summed)(1.0f - seed);
  summed s0 = b, s1 = b + 1.0f, s2 = b + 2.0f, s3 = b + 3.0f, s4 = b + 4.0f, s5 = b + 5.0f, s6 = b + 6.0f,
         s7 = b + 7.0f, s8 = b + 8.0f, s9 = b + 9.0f, s10 = b + 10.0f, s11 = b + 11.0f;
  for (int i = 0; i < rounds; ++i) {
    s0 = fma(s0, a, b); s1 = fma(s1, a, b); s2 = fma(s2, a, b); s3 = fma(s3, a, b);
    s4 = fma(s4, a, b); s5 = fma(s5, a, b); s6 = fma(s6, a, b); s7 = fma(s7, a, b);
    s8 = fma(s8, a, b); s9 = fma(s9, a, b); s10 = fma(s10, a, b); s11 = fma(s11, a, b);
  }
  out[get_global_id(0)] = s0 + s1 + s2 + s3 + s4 + s5 + s6 + s7 + s8 + s9 + s10 + s11;
}
)";

}  // namespace

cl::Device chosen_device() {
  const DeviceInfo info = Device().info();
  std::vector<cl::Platform> platforms;
  cl::Platform::get(&platforms);
  std::vector<cl::Device> devices;
  platforms.at(static_cast<std::size_t>(info.platform_index)).getDevices(CL_DEVICE_TYPE_ALL, &devices);
  return devices.at(static_cast<std::size_t>(info.device_index));
}

DeviceLimits::DeviceLimits() : context_(chosen_device()), queue_(context_) {
  const cl::Device device = chosen_device();
  wide_ = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_CPU) != 0;
  launches_ = wide_ ? 1 : kGroupLaunches;
  items_ = wide_ ? kItems : kItemsAUnit * device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  cl::Program program(context_, kSource);
  program.build(wide_ ? "-DWIDE=1" : "-DWIDE=0");
  copy_ = cl::Kernel(program, "copy");
  multiply_add_ = cl::Kernel(program, "multiply_add");
  sums_ = cl::Buffer(context_, CL_MEM_WRITE_ONLY, items_ * (wide_ ? kLanes : 1) * sizeof(float));
  multiply_add_.setArg(0, 0.25f);
  multiply_add_.setArg(1, kRounds);
  multiply_add_.setArg(2, sums_);
}

void DeviceLimits::copy(std::size_t bytes) {
  if (bytes != bytes_) {
    in_ = cl::Buffer(context_, CL_MEM_READ_ONLY, bytes);
    out_ = cl::Buffer(context_, CL_MEM_WRITE_ONLY, bytes);
    queue_.enqueueFillBuffer(in_, 0.5f, 0, bytes);
    queue_.enqueueFillBuffer(out_, 0.5f, 0, bytes);
    copy_.setArg(0, in_);
    copy_.setArg(1, out_);
    bytes_ = bytes;
  }
  const std::size_t items = bytes / ((wide_ ? 256 * kLanes : 4) * sizeof(float));
  enqueue(copy_, items);
  queue_.finish();
}

void DeviceLimits::multiply_add() {
  enqueue(multiply_add_, items_);
  queue_.finish();
}

void DeviceLimits::enqueue(const cl::Kernel& kernel, std::size_t items) const {
  for (int i = 0; i < launches_; ++i) {
    queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(wide_ ? 1 : kGroup));
  }
}

double DeviceLimits::copied(std::size_t bytes) const { return 2.0 * static_cast<double>(bytes) * launches_; }

double DeviceLimits::operations() const {
  return 2.0 * (wide_ ? kLanes : 1) * kChains * kRounds * static_cast<double>(items_) * launches_;
}

}  // namespace holdfast::bench
