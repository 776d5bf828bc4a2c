#include <algorithm>
#include <cmath>

#include "stopwatch.hpp"
#include "tracker_impl.hpp"

namespace holdfast {
namespace {

/// Steps below this many pixels of the level end a level's iterations.
constexpr double kConvergedPixels = 0.1;
/// A view is drawn anew when the pose has moved by more than this many pixels since.
constexpr double kRedrawPixels = 1.5;
/// Longest step of one solution, pixels of the level.
constexpr double kLongestStep = 3;
constexpr double kDamping = 1e-6;

/// Share of the blur's reach that must be known surface when `margin` pixels are dropped at a straight silhouette.
double coverage_at_margin(int margin, double sigma) {
  if (margin <= 0 || sigma <= 0) return 0.5;
  return 0.5 * std::erfc(-(margin + 0.5) / (sigma * std::sqrt(2.0))) - 1e-3;
}

}  // namespace

double Tracker::Impl::corner_motion(const Pose& T_a, const Pose& T_b) const {
  // Corners of a cube of the object's size: what a rotation or translation moves at its surface.
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const Eigen::Vector3d p_object = p_object_center_ + offset * (radius_ / std::sqrt(3.0));
    const Eigen::Vector3d a = T_a * p_object, b = T_b * p_object;
    if (a.z() <= 0 || b.z() <= 0) return 1e9;
    largest = std::max(largest, (levels_[0].camera.project(a) - levels_[0].camera.project(b)).norm());
  }
  return largest;
}

bool Tracker::Impl::draw(const Pose& T_camera_object, int finest, int count) {
  const Stopwatch watch(times_.filter);
  // Where the margin eats most of a small or thin object, drop less of it.
  const double relaxed = std::clamp((surviving_share_ - 0.2) / 0.3, 0.0, 1.0);
  const double full = coverage_at_margin(options_.silhouette_margin, options_.blur_sigma);
  ViewTemplate::Margin margin;
  margin.least_coverage = 0.6 + (full - 0.6) * relaxed;
  margin.depth_jump = options_.depth_jump;
  margin.jump_reach = relaxed > 0.5 ? std::max(1, options_.silhouette_margin) : 1;
  Exposure exposure;
  if (moved_ && exposure_ > 0) {
    exposure.twist = exposure_ * log_se3(T_camera_object * motion_.pose().inverse());
    exposure.pixels = exposure_ * corner_motion(motion_.pose(), T_camera_object);
  }
  const bool drawn = view_.enqueue(T_camera_object, finest, count, image_.grey(), margin, exposure);
  times_.render += view_.render_ms();
  times_.filter -= view_.render_ms();
  finest_drawn_ = finest;
  return drawn;
}

Estimate Tracker::Impl::iterate(int level, Pose& D, int iterations) {
  Estimate estimate;
  const Conditioning condition = conditioning();
  for (int i = 0; i < iterations; ++i) {
    estimate.sums = evaluate(level, D);
    const Solution solution = solve(estimate.sums, condition, kDamping);
    ++solved_systems_;
    estimate.solved = solution.solved;
    if (!solution.solved) break;
    const Pose before = D * view_.T_camera_object();
    const double motion = corner_motion(before, D * exp_se3(solution.twist) * view_.T_camera_object()) / (1 << level);
    // The rows are linear over about a pixel of blur: do not trust a longer step's length.
    const double shortened = iterations > 1 ? std::min(1.0, kLongestStep / std::max(motion, 1e-9)) : 1.0;
    D = renormalized(D * exp_se3(shortened * solution.twist));
    if (motion < kConvergedPixels) break;
  }
  estimate.T_camera_object = renormalized(D * view_.T_camera_object());
  estimate.correlation = Photometry::correlation(constraints_);
  // Pixels that left the sampled region speak against an estimate too.
  estimate.score = estimate.sums.used / std::max(1.0, estimate.sums.gradient) * estimate.sums.usable /
                   std::max(1.0, estimate.sums.visible) * std::max(0.0, estimate.correlation);
  return estimate;
}

Estimate Tracker::Impl::track_once(const Pose& T_predicted) {
  Estimate estimate;
  estimate.T_camera_object = T_predicted;
  if (!draw(T_predicted, 0, 1)) return estimate;
  {
    const Stopwatch watch(times_.filter);
    image_.enqueue_features(0, grown(view_.bounds(T_predicted), filter_.radius() + 4));
  }
  const Stopwatch watch(times_.solve);
  photometry_.start_level(0, view_.planes(0).tiles, false);
  Pose D = Pose::Identity();
  return iterate(0, D, 1);
}

Estimate Tracker::Impl::coarse_stage(const Pose& T_start, bool search, int coarsest, int finest) {
  Estimate estimate;
  estimate.T_camera_object = T_start;
  if (!draw(T_start, finest, coarsest - finest + 1)) return estimate;
  Pose D = Pose::Identity();
  if (search) {
    const Stopwatch watch(times_.search);
    const int radius = (options_.search_radius >> coarsest) + 1;
    const ShiftSearch::Result shift = search_.search(view_, image_, coarsest, radius);
    const Camera& camera = levels_[static_cast<std::size_t>(coarsest)].camera;
    if (shift.score > shift.unshifted + 0.02) {
      const double z = (T_start * p_object_center_).z();
      D.translation() = Eigen::Vector3d(shift.dx * z / camera.fx, shift.dy * z / camera.fy, 0);
    }
  }
  const Stopwatch watch(times_.solve);
  for (int level = coarsest; level >= finest; --level) {
    photometry_.start_level(level, view_.planes(level).tiles, level < coarsest);
    if (level == coarsest && options_.photometric) evaluate(level, D);
    estimate = iterate(level, D, options_.iterations);
    if (!estimate.solved) break;
  }
  return estimate;
}

Estimate Tracker::Impl::fine_stage(const Pose& T_start, int coarsest, bool lit_by_coarse_stage) {
  Estimate estimate;
  estimate.T_camera_object = T_start;
  const int finest = options_.finest_level;
  for (int redraw = 0; redraw < 2; ++redraw) {
    const Pose T_drawn = estimate.T_camera_object;
    const int top = redraw == 0 ? coarsest : finest;
    if (!draw(T_drawn, finest, top - finest + 1)) {
      estimate.solved = false;
      return estimate;
    }
    if (redraw == 0) {
      const Stopwatch watch(times_.filter);
      const Rect rect = grown(view_.bounds(T_drawn), (filter_.radius() + 4) << top);
      for (int level = finest; level <= top; ++level) image_.enqueue_features(level, coarser(rect, level));
    }
    const Stopwatch watch(times_.solve);
    Pose D = Pose::Identity();
    for (int level = top; level >= finest; --level) {
      // The tiles of the coarse stage's view lie where this view's do, up to a few pixels.
      photometry_.start_level(level, view_.planes(level).tiles, redraw == 0 && (level < top || lit_by_coarse_stage));
      estimate = iterate(level, D, options_.iterations);
      if (!estimate.solved) return estimate;
    }
    if (corner_motion(T_drawn, estimate.T_camera_object) < kRedrawPixels * (1 << finest)) break;
  }
  return estimate;
}

}  // namespace holdfast
