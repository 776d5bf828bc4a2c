#include <benchmark/benchmark.h>

#include <iostream>
#include <string>

#include "benchmarks.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"
#include "threads.hpp"

namespace {

int run(int argc, char** argv) {
  using namespace holdfast;
  const int threads = bench::use_threads(argc, argv);
  const DeviceInfo device = Device().info();
  benchmark::AddCustomContext("threads", std::to_string(threads));
  benchmark::AddCustomContext("device", device.name + ", " + device.platform_version);

  bench::Scenes scenes;
  bench::register_frames(scenes);
  bench::register_opencv_reference();
  bench::register_device_limits();
  bench::register_occlusion(scenes);
  bench::register_sweeps(scenes);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::ClearRegisteredBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "holdfast_bench: " << error.what() << '\n';
    return 1;
  }
}
