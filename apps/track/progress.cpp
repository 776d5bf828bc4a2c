#include "track/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

namespace holdfast::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kInterval{100};

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::ceil(seconds));
  if (whole < 60) {
    return fmt::format("{} s", whole);
  }
  if (whole < 3600) {
    return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  }
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

}  // namespace

std::string progress_text(std::int64_t done, std::optional<std::int64_t> expected, double elapsed_s) {
  std::string text =
      expected ? fmt::format("{} of {} frames, {} %", done, *expected, *expected > 0 ? 100 * done / *expected : 100)
               : fmt::format("{} frames", done);
  if (done > 0 && elapsed_s > 0) {
    const double rate = static_cast<double>(done) / elapsed_s;
    text += fmt::format(", {:.{}f} frames a second", rate, rate < 10 ? 1 : 0);
    if (expected && *expected >= done) {
      text += fmt::format(", {} left", duration_text(static_cast<double>(*expected - done) / rate));
    }
  }
  return text;
}

Progress::Progress(std::FILE* stream, std::optional<std::int64_t> expected)
    : stream_(stream),
      shown_(stream != nullptr && isatty(fileno(stream)) != 0),
      expected_(expected),
      begin_(Clock::now()),
      last_(begin_) {}

Progress::~Progress() { clear(); }

void Progress::update(std::int64_t done, bool held) {
  const Clock::time_point now = Clock::now();
  if (!shown_ || now - last_ < kInterval) {
    return;
  }
  last_ = now;
  const std::string text = progress_text(done, expected_, std::chrono::duration<double>(now - begin_).count());
  fmt::print(stream_, "\r\033[K{}, {}", text, held ? "held" : "lost");
  std::fflush(stream_);
  visible_ = true;
}

void Progress::clear() {
  if (visible_) {
    fmt::print(stream_, "\r\033[K");
    std::fflush(stream_);
    visible_ = false;
  }
}

}  // namespace holdfast::app
