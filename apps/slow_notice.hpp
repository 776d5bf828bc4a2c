#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace holdfast::app {

/// What making a tracker may wait for.
inline constexpr const char* kPreparing =
    "preparing: the first run on a device compiles kernels for it (half a minute; they are kept), and a large model "
    "takes a few seconds";

/// Standard error where a person reads it, else null.
std::FILE* terminal();

/// The stream for kPreparing: standard error where a person reads it or no kernels are kept yet (in the default folder,
/// if this one has no name), else null.
std::FILE* preparing_stream(const std::filesystem::path& cache_folder);

/// "holdfast: ..." on a stream, once, if it is still there after a while: something takes long that is usually quick.
class SlowNotice {
 public:
  /// Says nothing where there is no stream.
  SlowNotice(std::FILE* stream, std::string text, std::chrono::milliseconds patience = std::chrono::seconds(2));

 private:
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread waiting_;
};

/// Reads a live camera's next frame. Says on the stream when that takes longer than `patience`, and when frames come
/// again.
bool read_watched(const std::function<bool()>& read, std::FILE* stream,
                  std::chrono::milliseconds patience = std::chrono::seconds(1));

}  // namespace holdfast::app
