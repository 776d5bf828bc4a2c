#include <benchmark/benchmark.h>

#include <memory>
#include <string>

#include "benchmarks.hpp"
#include "device_limits.hpp"

namespace holdfast::bench {
namespace {

void copy(benchmark::State& state, std::size_t bytes) {
  DeviceLimits limits;
  limits.copy(bytes);
  for (auto _ : state) limits.copy(bytes);
  state.counters["GB_per_s"] =
      benchmark::Counter(1e-9 * limits.copied(bytes), benchmark::Counter::kIsIterationInvariantRate);
}

void multiply_add(benchmark::State& state) {
  DeviceLimits limits;
  limits.multiply_add();
  for (auto _ : state) limits.multiply_add();
  state.counters["GFLOP_per_s"] =
      benchmark::Counter(1e-9 * limits.operations(), benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

void register_device_limits() {
  for (const std::size_t kilobytes : {4096, 65536}) {  // within the caches, and from memory
    benchmark::RegisterBenchmark(("limit/copy/" + std::to_string(kilobytes)).c_str(), copy, 1024 * kilobytes)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RegisterBenchmark("limit/multiply_add", multiply_add)->UseRealTime()->Unit(benchmark::kMillisecond);
}

}  // namespace holdfast::bench
