// A held pose and its mirrored tilt: which of them frames show.

#include "base/turns.hpp"
#include "recovery/mirrored_tilt.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {
namespace {

/// Evidence, in scores, that decides between two poses; a frame gives 0.15 to 0.5 at a tilt of 20 degrees.
constexpr double kDecisive = 0.3;
/// Turns below which either is taken for the other from frame to frame.
constexpr double kOpenTurn = 0.25;
/// Two starts that lead to poses turned by less than this, radians, are compared again after so many frames.
constexpr double kOnePose = 0.02;
constexpr int kOnePosePause = 5;

}  // namespace

void Pipeline::tell_from_mirrored(Alignment& best, double time) {
  if (tuning_.paper() || !best.has_texture || !held(best)) return;
  const std::optional<Pose> T_mirrored = mirrored_tilt(view_, best.T_camera_object, extent_);
  if (!T_mirrored || turn_between(*T_mirrored, best.T_camera_object) < kOpenTurn) state_.tilt_evidence = 0;
  if (!T_mirrored || state_.tilt_evidence >= kDecisive || --state_.tilt_pause > 0) return;
  AlignmentPlan plan = fine_plan(state_.finest, state_);
  plan.expected = plan.measure = false;
  plan.all = true;
  // Light from one side is learned at the pose that was believed, and would speak for it.
  tried_ = state_;
  tried_.imaging.lit = false;
  const Alignment rival = aligner_.align(*T_mirrored, plan, tried_);
  const Alignment believed = aligner_.align(best.T_camera_object, plan, tried_);
  view_.clear();  // it is drawn in other light than light is learned from
  if (!rival.solved || !believed.solved) return;
  const double apart = turn_between(rival.T_camera_object, believed.T_camera_object);
  if (apart < kOnePose) state_.tilt_pause = kOnePosePause;
  if (apart < kSamePose) return;
  state_.tilt_evidence += believed.score - rival.score;
  if (state_.tilt_evidence > -kDecisive) {
    best.undecided = state_.tilt_evidence < kDecisive;
    return;
  }
  state_.tilt_evidence = kDecisive;
  state_.imaging.shading = {};
  state_.imaging.lit = false;
  state_.motion.reset(rival.T_camera_object);
  prior_ = state_.motion.predict(time);
  best = aligner_.align(rival.T_camera_object, fine_plan(state_.finest, state_), state_);
}

}  // namespace holdfast
