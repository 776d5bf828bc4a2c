#pragma once

#include <cstddef>
#include <vector>

#include "image/view_template.hpp"

namespace holdfast {

/// How frames showed an object of unknown appearance from several sides, for when it is lost.
class SnapshotAlbum {
 public:
  static constexpr std::size_t kMost = 16;

  void clear() { snapshots_.clear(); }
  /// Takes the place of one of nearly the same side; where the album is full, of the one that is nearest to another.
  void add(Snapshot snapshot);
  bool empty() const { return snapshots_.empty(); }

  /// The n-th in the order of turns away from a pose, beginning again after the last.
  const Snapshot& nearest(const Pose& T_camera_object, std::size_t n);

 private:
  std::vector<Snapshot> snapshots_;
};

}  // namespace holdfast
