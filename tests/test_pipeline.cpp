// The pipeline of `track`: reading, tracking and writing side by side, in order, to the end or to a signal.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <functional>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "track/interruption.hpp"
#include "track/pipeline.hpp"

using namespace holdfast::app;

namespace {

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Parts that hand numbered one-pixel frames through; a test replaces what it is about.
struct CountingParts {
  explicit CountingParts(int frames) {
    parts.next = [this, frames](Frame& frame) {
      if (read == frames) {
        return false;
      }
      frame.image.create(1, 1, CV_32S);
      frame.image.at<int>(0, 0) = read;
      frame.index = read++;
      return true;
    };
    parts.track = [](TrackedFrame& tracked) { tracked.result.iterations = static_cast<int>(tracked.frame.index); };
    parts.is_pictured = [](std::int64_t) { return false; };
    parts.write = [this](TrackedFrame& tracked) {
      written.push_back(tracked.frame.index);
      results.push_back(tracked.result.iterations);
      pictures.push_back(tracked.pictured ? tracked.frame.image.at<int>(0, 0) : -1);
    };
    parts.is_interrupted = [] { return false; };
  }

  std::atomic<int> read = 0;
  std::vector<std::int64_t> written;
  std::vector<int> results;
  std::vector<int> pictures;
  PipelineParts parts;
};

std::vector<std::int64_t> numbers_up_to(std::int64_t count) {
  std::vector<std::int64_t> numbers;
  for (std::int64_t i = 0; i < count; ++i) {
    numbers.push_back(i);
  }
  return numbers;
}

std::string what_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

/// Where threads wait until three of them are there; for ten seconds, so that one alone fails instead of hanging.
class Meeting {
 public:
  void join() {
    std::unique_lock lock(mutex_);
    ++here_;
    changed_.notify_all();
    changed_.wait_for(lock, std::chrono::seconds(10), [this] { return here_ >= 3; });
    met_ = here_ >= 3 && met_;
  }
  bool all_met() const { return here_ == 3 && met_; }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int here_ = 0;
  bool met_ = true;
};

}  // namespace

TEST_CASE("the pipeline hands every frame on, in order, each with its own result and picture") {
  CountingParts counting(200);
  const std::set<std::int64_t> pictured = {0, 1, 5, 6, 7, 100, 198, 199};
  counting.parts.is_pictured = [&](std::int64_t ordinal) { return pictured.contains(ordinal); };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.frames == 200);
  CHECK_FALSE(report.interrupted);
  CHECK_FALSE(report.failure);
  CHECK(counting.written == numbers_up_to(200));
  for (int i = 0; i < 200; ++i) {
    CHECK(counting.results[i] == i);
    CHECK(counting.pictures[i] == (pictured.contains(i) ? i : -1));
  }
}

TEST_CASE("the pipeline's parts work side by side, and none runs far ahead") {
  CountingParts counting(30);
  Meeting meeting;  // of reading frame 5, tracking frame 3 and writing frame 1
  int farthest_ahead = 0;
  const auto next = counting.parts.next;
  counting.parts.next = [&](Frame& frame) {
    if (counting.read == 5) meeting.join();
    return next(frame);
  };
  counting.parts.track = [&](TrackedFrame& tracked) {
    if (tracked.frame.index == 3) meeting.join();
    sleep_ms(2);
    farthest_ahead = std::max(farthest_ahead, counting.read - static_cast<int>(tracked.frame.index));
  };
  const auto write = counting.parts.write;
  counting.parts.write = [&](TrackedFrame& tracked) {
    if (tracked.frame.index == 1) meeting.join();
    write(tracked);
  };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.frames == 30);
  CHECK(meeting.all_met());
  CHECK(report.track_s > 0);
  CHECK(farthest_ahead <= 5);
}

TEST_CASE("frames before a failure are written, and the failure is reported") {
  CountingParts counting(50);
  SUBCASE("reading") {
    const auto next = counting.parts.next;
    counting.parts.next = [&](Frame& frame) {
      if (counting.read == 20) {
        throw std::runtime_error("frame 20 is spoiled");
      }
      return next(frame);
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "frame 20 is spoiled");
    CHECK(counting.written == numbers_up_to(20));
  }
  SUBCASE("tracking") {
    counting.parts.track = [](TrackedFrame& tracked) {
      if (tracked.frame.index == 20) {
        throw std::runtime_error("device lost");
      }
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "device lost");
    CHECK(counting.written == numbers_up_to(20));
  }
  SUBCASE("writing") {
    const auto write = counting.parts.write;
    counting.parts.write = [&](TrackedFrame& tracked) {
      if (tracked.frame.index == 20) {
        throw std::runtime_error("disk full");
      }
      write(tracked);
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "disk full");
    CHECK(counting.written == numbers_up_to(20));
    CHECK(report.frames == 20);
    CHECK(counting.read < 35);  // the others stopped soon
  }
}

TEST_CASE("an interrupted pipeline finishes the frames it has tracked") {
  CountingParts counting(1000000);
  std::atomic<int> tracked_count = 0;
  counting.parts.track = [&](TrackedFrame&) { ++tracked_count; };
  counting.parts.is_interrupted = [&] { return tracked_count == 25; };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.interrupted);
  CHECK_FALSE(report.failure);
  CHECK(counting.written == numbers_up_to(25));
}

TEST_CASE("a live input drops the oldest frames when tracking is slow, a recorded one none") {
  for (const bool live : {true, false}) {
    CAPTURE(live);
    CountingParts counting(60);
    counting.parts.live = live;
    const auto next = counting.parts.next;
    counting.parts.next = [&](Frame& frame) {
      sleep_ms(1);
      return next(frame);
    };
    std::vector<int> ages;
    counting.parts.track = [&](TrackedFrame& tracked) {
      ages.push_back(counting.read - static_cast<int>(tracked.frame.index));
      sleep_ms(6);
    };
    run_pipeline(counting.parts);
    CHECK(std::is_sorted(counting.written.begin(), counting.written.end()));
    CHECK(counting.written.back() == 59);
    CHECK((counting.written.size() < 60) == live);
    CHECK(*std::max_element(ages.begin(), ages.end()) <= 5);
  }
}

TEST_CASE("signals are remembered while somebody listens") {
  {
    const Interruption interruption;
    CHECK_FALSE(interruption.requested());
    std::raise(SIGTERM);
    CHECK(interruption.requested());
  }
  {
    const Interruption again;
    CHECK_FALSE(again.requested());
    std::raise(SIGINT);
    CHECK(again.requested());
  }
  {
    const Interruption hung_up;
    std::raise(SIGPIPE);  // an error of whoever writes
    CHECK_FALSE(hung_up.requested());
    std::raise(SIGHUP);
    CHECK(hung_up.requested());
  }
  const auto previous = std::signal(SIGHUP, SIG_IGN);  // nohup
  {
    const Interruption left_running;
    std::raise(SIGHUP);
    CHECK_FALSE(left_running.requested());
  }
  std::signal(SIGHUP, previous);
}
