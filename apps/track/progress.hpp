#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace holdfast::app {

/// One line on a terminal that tells how far a run is; nothing where `stream` is no terminal.
class Progress {
 public:
  Progress(std::FILE* stream, std::optional<std::int64_t> expected);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After each frame.
  void update(std::int64_t done, bool held);
  /// Removes the line.
  void clear();

 private:
  std::FILE* stream_;
  bool shown_;
  bool visible_ = false;
  std::optional<std::int64_t> expected_;
  std::chrono::steady_clock::time_point begin_;
  std::chrono::steady_clock::time_point last_;
};

/// "120 of 455 frames, 26 %, 212 frames a second, 2 s left"; what is not known is left out.
std::string progress_text(std::int64_t done, std::optional<std::int64_t> expected, double elapsed_s);

}  // namespace holdfast::app
