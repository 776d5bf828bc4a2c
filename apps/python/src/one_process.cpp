#include "one_process.hpp"

#include <unistd.h>

#include <atomic>

#include "holdfast/error.hpp"

namespace holdfast::python {

void require_one_process() {
  static std::atomic<pid_t> first{0};
  pid_t used_by = 0;
  if (first.compare_exchange_strong(used_by, getpid()) || used_by == getpid()) return;
  throw Error(ErrorCode::device,
              "holdfast was used before this process was forked, and OpenCL's threads are not in the child: use "
              "multiprocessing's start method 'spawn', multiprocessing.get_context('spawn')");
}

}  // namespace holdfast::python
