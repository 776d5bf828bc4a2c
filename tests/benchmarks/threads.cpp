#include "threads.hpp"

#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <opencv2/core.hpp>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast::bench {
namespace {

/// Without it one thread would have another core's help while it waits for it.
void use_cores(int count) {
  cpu_set_t cores, wanted;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) return;
  CPU_ZERO(&wanted);
  for (int core = 0, left = count; core < CPU_SETSIZE && left > 0; ++core) {
    if (CPU_ISSET(core, &cores)) {
      CPU_SET(core, &wanted);
      --left;
    }
  }
  sched_setaffinity(0, sizeof(wanted), &wanted);
}

}  // namespace

int use_threads(int& argc, char** argv) {
  int threads = 2;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::strcmp(argv[i], "--threads") != 0) continue;
    threads = std::atoi(argv[i + 1]);
    std::copy(argv + i + 2, argv + argc, argv + i);
    argc -= 2;
    break;
  }
  if (threads < 1) throw Error(ErrorCode::invalid_argument, "--threads must be 1 or more");
  const std::string count = std::to_string(threads);
  setenv("POCL_MAX_PTHREAD_COUNT", count.c_str(), 1);
  setenv("LP_NUM_THREADS", threads == 1 ? "0" : count.c_str(), 1);  // 0: the calling thread draws
  cv::setNumThreads(threads);
  use_cores(threads);
  return threads;
}

}  // namespace holdfast::bench
