#include <benchmark/benchmark.h>
#include <sched.h>

#include <cstdlib>
#include <cstring>
#include <iostream>
#include <opencv2/core.hpp>

#include "benchmarks.hpp"
#include "holdfast/error.hpp"

namespace {

/// As many threads for OpenCL, for drawing and for OpenCV. PoCL and Mesa read these variables once, when they start.
void use_threads(int threads) {
  const std::string count = std::to_string(threads);
  setenv("POCL_MAX_PTHREAD_COUNT", count.c_str(), 1);
  setenv("LP_NUM_THREADS", threads == 1 ? "0" : count.c_str(), 1);  // 0: the calling thread draws
  cv::setNumThreads(threads);
  // One core for the whole process, or one thread would have another one's help while it waits for it.
  cpu_set_t cores, wanted;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) return;
  CPU_ZERO(&wanted);
  for (int core = 0, left = threads; core < CPU_SETSIZE && left > 0; ++core) {
    if (CPU_ISSET(core, &cores)) {
      CPU_SET(core, &wanted);
      --left;
    }
  }
  sched_setaffinity(0, sizeof(wanted), &wanted);
}

int run(int argc, char** argv) {
  int threads = 2;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::strcmp(argv[i], "--threads") != 0) continue;
    threads = std::atoi(argv[i + 1]);
    std::copy(argv + i + 2, argv + argc, argv + i);
    argc -= 2;
    break;
  }
  if (threads < 1) {
    std::cerr << "holdfast_bench: --threads must be 1 or more\n";
    return 2;
  }
  use_threads(threads);
  benchmark::AddCustomContext("threads", std::to_string(threads));

  holdfast::bench::Scenes scenes;
  holdfast::bench::register_frames(scenes);
  holdfast::bench::register_opencv_reference();
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
  } catch (const holdfast::Error& error) {
    std::cerr << "holdfast_bench: " << error.what() << '\n';
    return 1;
  }
}
