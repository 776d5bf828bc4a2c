#include "slow_notice.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <mutex>
#include <stop_token>
#include <utility>

namespace holdfast::app {

std::FILE* terminal() { return isatty(STDERR_FILENO) == 1 ? stderr : nullptr; }

SlowNotice::SlowNotice(std::FILE* stream, std::string text, std::chrono::milliseconds patience) {
  if (stream == nullptr) {
    return;
  }
  waiting_ = std::jthread([this, stream, text = std::move(text), patience](const std::stop_token& ended) {
    std::unique_lock lock(mutex_);
    ended_.wait_for(lock, ended, patience, [] { return false; });
    if (!ended.stop_requested()) {
      fmt::print(stream, "holdfast: {}\n", text);
    }
  });
}

}  // namespace holdfast::app
