#include "slow_notice.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <stop_token>
#include <system_error>
#include <utility>

#include "holdfast/device.hpp"

namespace holdfast::app {

std::FILE* terminal() { return isatty(STDERR_FILENO) == 1 ? stderr : nullptr; }

std::FILE* preparing_stream(const std::filesystem::path& cache_folder) {
  std::error_code none;
  const std::filesystem::directory_iterator kept(cache_folder.empty() ? default_cache_folder() : cache_folder, none);
  const bool compiled = std::any_of(begin(kept), end(kept), [](const std::filesystem::directory_entry& file) {
    return file.path().extension() == ".clbin";
  });
  return compiled ? terminal() : stderr;
}

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

bool read_watched(const std::function<bool()>& read, std::FILE* stream, std::chrono::milliseconds patience) {
  const auto begin = std::chrono::steady_clock::now();
  bool there = false;
  {
    const SlowNotice notice(stream, fmt::format("the camera has delivered nothing for {} ms", patience.count()),
                            patience);
    there = read();
  }
  if (stream != nullptr && there && std::chrono::steady_clock::now() - begin > patience) {
    fmt::print(stream, "holdfast: the camera delivers frames again\n");
  }
  return there;
}

}  // namespace holdfast::app
