#include "recovery/snapshot_album.hpp"

#include <algorithm>
#include <utility>

#include "base/turns.hpp"

namespace holdfast {
namespace {

/// Turns of less than this, radians, show the same side.
constexpr double kSameSide = 0.25;

}  // namespace

void SnapshotAlbum::add(Snapshot snapshot) {
  const auto to_new = [&](const Snapshot& other) {
    return turn_between(other.T_camera_object, snapshot.T_camera_object);
  };
  const auto nearest = std::ranges::min_element(snapshots_, {}, to_new);
  if (nearest != snapshots_.end() && to_new(*nearest) < kSameSide) {
    if (snapshot.sure || !nearest->sure) *nearest = std::move(snapshot);
    return;
  }
  if (snapshots_.size() == kMost) {
    const auto to_others = [&](const Snapshot& one) {
      double least = 10;
      for (const Snapshot& other : snapshots_) {
        if (&other != &one) least = std::min(least, turn_between(one.T_camera_object, other.T_camera_object));
      }
      return least;
    };
    *std::ranges::min_element(snapshots_, {}, to_others) = std::move(snapshot);
    return;
  }
  snapshots_.push_back(std::move(snapshot));
}

const Snapshot& SnapshotAlbum::nearest(const Pose& T_camera_object, std::size_t n) {
  std::ranges::stable_sort(snapshots_, {},
                           [&](const Snapshot& one) { return turn_between(one.T_camera_object, T_camera_object); });
  return snapshots_[n % snapshots_.size()];
}

}  // namespace holdfast
