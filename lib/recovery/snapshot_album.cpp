#include "recovery/snapshot_album.hpp"

#include <algorithm>
#include <utility>

namespace holdfast {
namespace {

/// Turns of less than this, radians, show the same side.
constexpr double kSameSide = 0.25;

double turn(const Pose& T_a, const Pose& T_b) { return rotation_angle(T_a.linear() * T_b.linear().transpose()); }

}  // namespace

void SnapshotAlbum::add(Snapshot snapshot) {
  const auto to_new = [&](const Snapshot& other) { return turn(other.T_camera_object, snapshot.T_camera_object); };
  const auto nearest = std::ranges::min_element(snapshots_, {}, to_new);
  if (nearest != snapshots_.end() && to_new(*nearest) < kSameSide) {
    if (snapshot.sure || !nearest->sure) *nearest = std::move(snapshot);
    return;
  }
  if (snapshots_.size() == kMost) {
    const auto to_others = [&](const Snapshot& one) {
      double least = 10;
      for (const Snapshot& other : snapshots_) {
        if (&other != &one) least = std::min(least, turn(one.T_camera_object, other.T_camera_object));
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
                           [&](const Snapshot& one) { return turn(one.T_camera_object, T_camera_object); });
  return snapshots_[n % snapshots_.size()];
}

}  // namespace holdfast
