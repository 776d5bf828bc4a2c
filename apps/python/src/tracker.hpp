#pragma once

#include <nanobind/nanobind.h>

#include <mutex>
#include <optional>

#include "holdfast/tracker.hpp"
#include "one_process.hpp"
#include "track/object_search.hpp"

namespace holdfast::python {

/// A tracker that threads may share: calls run one after the other, without the interpreter's lock.
struct SharedTracker {
  Tracker tracker;
  const Mesh& mesh;  ///< Python keeps it as long as the tracker
  mutable std::mutex mutex;
  std::optional<app::StartSearch> search;  ///< made by the first find()
  std::optional<Pose> T_guide;             ///< that it is made for
  app::Recognition recognition;            ///< with the file of remember()
  std::optional<app::Memory> memory;       ///< made by remember()
};

/// Runs `work` on the tracker without the interpreter's lock.
template <class Self, class Work>
auto unlocked(Self& self, const Work& work) {
  require_one_process();
  const nanobind::gil_scoped_release released;
  const std::lock_guard alone(self.mutex);
  return work(self.tracker);
}

}  // namespace holdfast::python
