#pragma once

#include <optional>
#include <span>
#include <vector>

#include "evaluation/protocol.hpp"
#include "evaluation/statistics.hpp"

namespace holdfast::evaluation {

/// Share of frames within a tolerance, and the first frame that is not.
struct Within {
  double share = 0;                 ///< of the counted frames, 0 to 1
  std::optional<int> first_beyond;  ///< frame number; the smallest one over all offsets
  int frames_to_first_beyond = 0;   ///< tracked frames before it (all of them where there is none), fewest over offsets
};

/// Figures of the frames that were counted.
struct Summary {
  int frames = 0;   ///< counted
  int skipped = 0;  ///< tracked, too little visible to count
  Within failure;   ///< the protocol's own threshold; its share is RBOT's success
  Within within_50mm_5deg;
  Within within_20mm_2deg;
  Within within_10mm_2deg;

  Spread distance;     ///< metres, all counted frames
  Spread rotation;     ///< radians, all counted frames
  Spread distance_ok;  ///< metres, frames that did not fail
  Spread rotation_ok;  ///< radians, frames that did not fail

  int lost_frames = 0;        ///< counted frames reported lost
  int confidently_wrong = 0;  ///< counted frames reported held while more than 20 mm or 5 degrees off
  double ms_median = 0;       ///< milliseconds a frame; NaN where not known
  double ms_p95 = 0;
};

/// Sums up the frames of one step, of one or several offsets.
Summary summarize(std::span<const FrameRecord> records);

}  // namespace holdfast::evaluation
