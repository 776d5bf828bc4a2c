#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "evaluation/pose_error.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::evaluation {

struct FrameRecord;

/// What a protocol needs of a tracker; any will do.
struct TrackerUnderTest {
  /// The object is at this pose; forget everything else. May throw Error(pose) where the pose cannot be started from.
  std::function<void(const Pose& T_camera_object)> reset;
  /// The same, shown the frame of this index, in which the pose holds. May be empty: then reset() is called.
  std::function<void(const Pose& T_camera_object, int frame)> reset_on = {};
  /// Where is it in the frame of this index? `ms.total` of the answer is what the frame cost.
  std::function<FrameResult(int frame)> track;
  /// May be empty. Called after every frame that counts as tracked, with its record: a look at the tracker's inside.
  std::function<void(FrameRecord& record)> inspect = {};
};

enum class Protocol {
  never_reset,  ///< starts at the first frame's true pose, is asked for that frame too, and left alone
  rbot,  ///< starts at the first frame's true pose, is asked from the next one on, and put back to the truth after
         ///< every frame that fails
};

struct ProtocolOptions {
  Protocol protocol = Protocol::never_reset;
  int step = 1;                                     ///< every step-th frame
  int offset = 0;                                   ///< the first of them
  Tolerance failure = tolerance_mm_deg(50.0, 5.0);  ///< a frame beyond this fails
  double minimum_visible = 0;  ///< frames with a smaller visible share count neither way and bring no reset
  /// Whenever the tracker is put to a true pose in the rbot protocol it is shown that very frame (not counted), as
  /// trackers are that learn from the image they start on.
  bool show_start_frame = true;
  std::function<bool()> is_interrupted = {};  ///< may be empty; asked before each frame, true ends the run there
};

/// Pixels that decided a pose, and how many of them show an occluder and not the object.
struct OccluderUse {
  int used = 0;
  int on_occluder = 0;
  bool overlaps = false;  ///< the occluder covers some of the object as rendered at the estimated pose
};

/// One frame that the tracker was asked for.
struct FrameRecord {
  int frame = 0;
  int step = 1;
  int offset = 0;
  Pose T_camera_object_true = Pose::Identity();
  FrameResult result;  ///< result.ms.total: wall time of tracking without loading the image; 0 where unknown
  PoseError error;
  double visible = 1;                   ///< visible share of the object's silhouette
  bool counted = true;                  ///< visible enough
  bool failed = false;                  ///< beyond ProtocolOptions::failure; never where not counted
  double add = -1;                      ///< metres, ModelPoints::add(); negative: not computed
  double add_s = -1;                    ///< metres
  std::optional<OccluderUse> occluder;  ///< where the sequence tells where occluders are
};

/// Runs one tracker over one sequence. `truth` holds a pose a frame, `visible` a share a frame or nothing (all
/// visible). Throws Error(invalid_argument) for a step or offset that leaves no frame, or sizes that differ.
std::vector<FrameRecord> run_protocol(std::span<const Pose> truth, std::span<const double> visible,
                                      const TrackerUnderTest& tracker, const ProtocolOptions& options);

/// Starts from a pose that is wrong, spread evenly over the sequence.
struct StartOptions {
  int count = 200;
  double translation = 0.01;        ///< metres; of each start a random share up to all of it, any direction
  double rotation = to_radians(5);  ///< radians, about the model's origin; likewise
  int frames = 5;                   ///< tracked from each start on, the one it starts at among them
  std::uint64_t seed = 1;
};

/// One record a start: the last of its frames. `offset` counts starts.
std::vector<FrameRecord> run_starts(std::span<const Pose> truth, std::span<const double> visible,
                                    const TrackerUnderTest& tracker, const StartOptions& options,
                                    const ProtocolOptions& judged);

}  // namespace holdfast::evaluation
