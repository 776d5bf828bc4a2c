#include "track/pipeline.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "track/channel.hpp"

namespace holdfast::app {
namespace {

// One in each part's hands and one waiting between neighbours.
constexpr int kFrameBuffers = 4;
constexpr int kTrackedBuffers = 3;

/// Adds the time spent in a call to `busy_s`.
template <class Call>
auto timed(double& busy_s, const Call& call) {
  struct Timer {
    double& busy_s;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    ~Timer() { busy_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); }
  } timer{busy_s};
  return call();
}

class Pipeline {
 public:
  explicit Pipeline(const PipelineParts& parts) : parts_(parts) {
    for (int i = 0; i < kFrameBuffers; ++i) {
      free_frames_.push({});
    }
    for (int i = 0; i < kTrackedBuffers; ++i) {
      free_tracked_.push({});
    }
  }

  PipelineReport run() {
    std::thread reader([this] { read_all(); });
    std::thread writer([this] { write_all(); });
    std::exception_ptr track_failure;
    try {
      track_all();
    } catch (...) {
      track_failure = std::current_exception();
    }
    // The reader stops wherever it waits; the writer finishes what was tracked.
    stopping_ = true;
    frames_.abandon();
    free_frames_.abandon();
    tracked_.close();
    reader.join();
    writer.join();
    report_.wall_s = seconds();
    for (const std::exception_ptr& failure : {write_failure_, track_failure, read_failure_}) {
      if (failure && !report_.failure) {
        report_.failure = failure;
      }
    }
    return report_;
  }

 private:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

  std::optional<Frame> buffer_for_reading() {
    std::optional<Frame> buffer = free_frames_.try_pop();
    if (!buffer && parts_.live) {
      buffer = frames_.try_pop();  // the oldest that waits
    }
    return buffer ? std::move(buffer) : free_frames_.pop();
  }

  void read_all() {
    try {
      while (!stopping_) {
        std::optional<Frame> frame = buffer_for_reading();
        if (!frame || !timed(report_.read_s, [&] { return parts_.next(*frame); })) {
          break;
        }
        if (report_.first.read_s == 0) report_.first.read_s = report_.read_s;
        frames_.push(std::move(*frame));
      }
    } catch (...) {
      read_failure_ = std::current_exception();
    }
    frames_.close();
  }

  void track_all() {
    for (std::int64_t ordinal = 0;; ++ordinal) {
      if (parts_.is_interrupted()) {
        report_.interrupted = true;
        return;
      }
      std::optional<Frame> frame = frames_.pop();
      if (!frame) {
        return;
      }
      std::optional<TrackedFrame> tracked = free_tracked_.pop();
      if (!tracked) {  // the writer gave up
        return;
      }
      std::swap(tracked->frame, *frame);
      tracked->ordinal = ordinal;
      tracked->pictured = parts_.is_pictured(ordinal);
      timed(report_.track_s, [&] { parts_.track(*tracked); });
      if (ordinal == 0) report_.first.track_s = report_.track_s;
      if (!tracked->pictured) {
        std::swap(tracked->frame.image, frame->image);
      }
      free_frames_.push(std::move(*frame));
      tracked_.push(std::move(*tracked));
    }
  }

  void write_all() {
    try {
      while (std::optional<TrackedFrame> tracked = tracked_.pop()) {
        timed(report_.write_s, [&] { parts_.write(*tracked); });
        if (report_.frames++ == 0) {
          report_.first.write_s = report_.write_s;
          report_.first.wall_s = seconds();
        }
        free_tracked_.push(std::move(*tracked));
      }
    } catch (...) {
      write_failure_ = std::current_exception();
    }
    free_tracked_.abandon();
  }

  const PipelineParts& parts_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  PipelineReport report_;
  Channel<Frame> free_frames_;
  Channel<Frame> frames_;
  Channel<TrackedFrame> free_tracked_;
  Channel<TrackedFrame> tracked_;
  std::atomic<bool> stopping_ = false;
  std::exception_ptr read_failure_;
  std::exception_ptr write_failure_;
};

}  // namespace

PipelineReport run_pipeline(const PipelineParts& parts) { return Pipeline(parts).run(); }

}  // namespace holdfast::app
