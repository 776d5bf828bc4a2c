// The paper's tracker: one view, one solution.
#include <Eigen/Cholesky>

#include "base/stopwatch.hpp"
#include "tracker/aligner.hpp"

namespace holdfast {

Alignment Aligner::align_once(const Pose& T_start, const TrackingState& state) {
  Alignment alignment;
  alignment.T_camera_object = T_start;
  alignment.imaging = state.imaging;
  {
    const Stopwatch watch(times_.filter);
    image_.enqueue_blur(0, grown(view_.bounds(T_start), ImageFilter::kMargin));
    device_.queue.flush();
  }
  if (!draw(T_start, 0, 1, state, state.imaging)) return alignment;
  const Stopwatch watch(times_.solve);
  texture_.start_level(view_, 0);
  alignment.texture =
      texture_.linearize(view_, image_, Pose::Identity(), {0, 0, 1, true, false}, alignment.imaging.texture);
  alignment.has_texture = true;
  AlignmentPlan plan;
  plan.expected = tuning_.expected_motion && state.motion.moving();
  NormalEquations equations = alignment.texture.equations;
  if (alignment.texture.sums.rows < 6) return alignment;
  if (tuning_.expected_motion) equations += prior_equations(T_start, plan, T_start);
  const Twist y = equations.A.ldlt().solve(equations.h);
  alignment.solved = y.allFinite() && alignment.texture.reliability > 0;
  ++solved_systems_;
  if (!alignment.solved) return alignment;
  alignment.last_step_camera = to_camera_axes(T_start) * y;
  alignment.T_camera_object = perturbed(T_start, y, extent_);
  alignment.score = score(alignment, state, state.usual.expected_texture_score());
  const Matrix6 others = prior_equations(T_start, plan, T_start).A;
  alignment.covariance = texture_.covariance(view_, alignment.texture, alignment.last_step_camera, others);
  return alignment;
}

}  // namespace holdfast
