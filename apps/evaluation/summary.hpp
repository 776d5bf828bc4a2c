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

/// ADD or ADD-S over the counted frames, against the model's diameter.
struct DistanceScores {
  double below_2_percent = 0;   ///< share of frames with a distance below 2 % of the diameter
  double below_5_percent = 0;   ///< the same for 5 %
  double below_10_percent = 0;  ///< the same for 10 %: what is usually called "ADD"
  double auc_100mm = 0;         ///< area under accuracy over threshold up to 0.1 m, 0 to 100 (PoseCNN)
  double auc_opt = 0;           ///< the same up to 0.2 diameters, 0 to 20 (OPT)
  Spread distance;              ///< metres
};

/// A stretch of frames in which the object was reported lost or was beyond the failure tolerance.
struct Loss {
  int step = 1;
  int offset = 0;
  int first_frame = 0;                  ///< frame number
  std::optional<int> reacquired_frame;  ///< frame number of the first good frame after it
  int frames = 0;                       ///< tracked frames that it lasted
  /// Tracked frames of it since the visible share last rose to kVisibleAgain (all of them where it never was below):
  /// how long the tracker took once it could see. 0 where it came back before.
  int frames_since_visible = 0;
};

inline constexpr double kVisibleAgain = 0.5;

/// How well the reported covariance fits the errors, over counted frames that are held and bring an information matrix.
struct Coverage {
  int frames = 0;
  double inside_95 = 0;       ///< share of errors inside the 95 % ellipsoid; 0.95 where the covariance is right
  double median_squared = 0;  ///< median of normalized_error_squared(); 5.35 where the covariance is right
};

/// Pixels of occluders among those that decided poses, over the counted frames in which an occluder covers some of the
/// object.
struct OccluderShare {
  int frames = 0;
  double share = 0;        ///< of all pixels used in these frames
  double worst_frame = 0;  ///< largest share in one of these frames
};

/// Figures of one step, over all offsets.
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
  Spread x;            ///< metres, sizes of the errors along the camera's axes, all counted frames
  Spread y;            ///< metres
  Spread depth;        ///< metres, along z
  Spread lateral;      ///< metres, across z

  std::optional<DistanceScores> add;    ///< where every counted frame has it
  std::optional<DistanceScores> add_s;  ///< where every counted frame has it

  std::vector<Loss> losses;
  int lost_frames = 0;        ///< counted frames reported lost
  int confidently_wrong = 0;  ///< counted frames reported held while more than 20 mm or 5 degrees off
  Coverage coverage;
  std::optional<OccluderShare> occluder;  ///< where there are such frames and the sequence says where occluders are

  double ms_median = 0;  ///< milliseconds a frame; NaN where not known
  double ms_p95 = 0;
};

/// Sums up the frames of one step, of one or several offsets, each offset's frames in order. `failure` is what the
/// protocol judged by; `diameter` the model's, metres, 0 where no model is known (then no ADD).
Summary summarize(std::span<const FrameRecord> records, const Tolerance& failure, double diameter = 0);

}  // namespace holdfast::evaluation
