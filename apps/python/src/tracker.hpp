#pragma once

#include <nanobind/nanobind.h>

#include <mutex>

#include "holdfast/tracker.hpp"

namespace holdfast::python {

/// A tracker that threads may share: calls wait for each other while the interpreter's lock is released.
struct SharedTracker {
  Tracker tracker;
  mutable std::mutex mutex;
};

/// Runs `work` on the tracker without the interpreter's lock.
template <class Self, class Work>
auto unlocked(Self& self, const Work& work) {
  const nanobind::gil_scoped_release released;
  const std::lock_guard alone(self.mutex);
  return work(self.tracker);
}

}  // namespace holdfast::python
