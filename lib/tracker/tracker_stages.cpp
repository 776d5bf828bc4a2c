#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Steps below this many pixels of the level end a level's iterations; each step is about a quarter of the one before.
constexpr double kConvergedPixels = 0.05, kConvergedPixelsCoarse = 0.4;
/// A view is drawn anew when the pose has moved by more than this many pixels since.
constexpr double kRedrawPixels = 1.5;
/// Views that an object found again is looked at in, at most.
constexpr int kMostSettling = 4;
/// Longest step of one solution, pixels of the level.
constexpr double kLongestStep = 3;
constexpr double kDamping = 1e-6;
/// What 1/Z bends by at an edge of flat faces, of itself.
constexpr double kBend = 6e-4;

/// Share of the blur's reach that must be known surface when `margin` pixels, `wider` times as many, are dropped at a
/// straight silhouette.
double coverage_at_margin(double margin, double wider, double sigma) {
  if (margin <= 0 || sigma <= 0) return 0.5;
  return 0.5 * std::erfc(-(margin + 0.5) * wider / (sigma * std::sqrt(2.0))) - 1e-3;
}

}  // namespace

double Tracker::Impl::corner_motion(const Pose& T_a, const Pose& T_b) const {
  return holdfast::corner_motion({p_object_center_, radius_}, levels_[0].camera, T_a, T_b);
}

ViewRequest Tracker::Impl::view_request(const Pose& T_camera_object, int finest, int count, bool across) const {
  ViewRequest request;
  request.T_camera_object = T_camera_object;
  request.finest = finest;
  request.count = count;
  request.grey = image_.grey();
  request.coarse_color = options_.coarse_color && look_.optics.coarse_color.on;
  // Where the margin eats most of a small or thin object, drop less of it.
  const double relaxed = std::clamp((look_.surviving_share - 0.2) / 0.3, 0.0, 1.0);
  // The lens carries what is behind the object farther in.
  const double lens = std::sqrt(look_.optics.lens_variance) / (1 << finest);
  const double sigma = filter_.sigma(finest);
  const double wider = sigma > 0 ? std::hypot(1.0, lens / sigma) : 1.0;
  const double full = coverage_at_margin(options_.silhouette_margin, wider, sigma);
  Margin& margin = request.margin;
  margin.least_coverage = 0.6 + (full - 0.6) * relaxed;
  margin.depth_jump = options_.depth_jump;
  // The lens blurs the step of brightness between faces as light, which moves it.
  if (faceted_ && relaxed > 0.5) margin.bend = kBend;
  margin.jump_reach = relaxed > 0.5 ? std::max(1, options_.silhouette_margin) : 1;
  if (options_.motion_blur && moved_ && look_.exposure > 0) {
    Exposure& exposure = request.exposure;
    exposure.twist = look_.exposure * log_se3(T_camera_object * motion_.pose().inverse());
    exposure.light = look_.exposed_light;
    exposure.across = across;
    exposure.pixels = look_.exposure * corner_motion(motion_.pose(), T_camera_object);
  }
  if (look_.lit) request.shading = look_.shading.direction();
  request.tone = look_.tone.drawn();
  request.light_texels = options_.light_texels && look_.optics.light_texels.on;
  request.lens_blur = lens;
  return request;
}

bool Tracker::Impl::draw(const ViewRequest& request) {
  const Stopwatch watch(times_.filter);
  T_compared_ = request.T_camera_object;
  finest_drawn_ = request.finest;
  decided_ = false;
  const std::optional<DrawnAhead> ahead = std::exchange(ahead_, {});
  if (ahead && ahead->fine_level == filter_.fine_level() && ahead->request == request) {
    times_.ahead = ahead->ms;
    return true;
  }
  const bool drawn = view_.enqueue(request);
  times_.render += view_.render_ms();
  times_.filter -= view_.render_ms();
  return drawn;
}

void Tracker::Impl::forget_view() {
  view_.clear();
  ahead_.reset();
  T_compared_ = Pose::Identity();
  decided_ = false;
}

void Tracker::Impl::draw_ahead() {
  // A first frame's light, a loss and faint texture ask for more than one view, and not for this one first.
  if (ahead_ || !started_ || by_outline_ || course_.faint || course_.fresh() || motion_.lost()) return;
  DrawnAhead ahead;
  bool drawn = false;
  {
    const Stopwatch watch(ahead.ms);
    prepare_frame();
    const MotionModel::Hypotheses hypotheses = this->hypotheses();
    const Pose& T_predicted = hypotheses.poses[0];
    int finest = finest_, count = 1;
    if (options_.mode != Mode::paper && !(searches() && goes_directly())) {
      const Scope scope = this->scope(hypotheses, searches());
      if (scope.coarse()) {
        finest = scope.coarse_finest;
        count = scope.coarsest - scope.coarse_finest + 1;
      }
    }
    set_blur();
    ahead.request = view_request(T_predicted, finest, count);
    ahead.fine_level = filter_.fine_level();
    const Pose T_compared = T_compared_;
    drawn = draw(ahead.request);
    T_compared_ = T_compared;
    device_.impl().queue.flush();
  }
  if (drawn) ahead_ = ahead;
}

Estimate Tracker::Impl::iterate(int level, Pose& D, int iterations, double most_motion,
                                const OutlineEstimate* outline) {
  Estimate estimate;
  const Conditioning condition = conditioning();
  for (int i = 0; i < iterations; ++i) {
    estimate.sums = evaluate(level, D);
    estimate.looked_at_every = looked_at_every_;
    // Coarse levels are asked only where the frame before left a motion open: far from where it fits they would seem
    // to.
    const bool asked = course_.hides;
    const Seen motion = asked ? seen_motion(estimate.sums, level) : Seen();
    const Solution solution = solve(with_expectation(estimate.sums, D, motion, outline), condition, kDamping);
    ++solved_systems_;
    estimate.solved = solution.solved;
    estimate.last_step = solution.conditioned;
    if (!solution.solved) break;
    const Pose before = D * view_.T_camera_object();
    const double pixels = corner_motion(before, D * exp_se3(solution.twist) * view_.T_camera_object()) / (1 << level);
    // The rows are linear over about a pixel of blur: do not trust a longer step's length.
    const double shortened = iterations > 1 ? std::min(1.0, kLongestStep / std::max(pixels, 1e-9)) : 1.0;
    D = renormalized(D * exp_se3(shortened * solution.twist));
    if (most_motion < kAnyMotion && corner_motion(view_.T_camera_object(), D * view_.T_camera_object()) > most_motion) {
      estimate.solved = false;
      break;
    }
    if (pixels < (level > finest_ ? kConvergedPixelsCoarse : kConvergedPixels)) break;
  }
  estimate.T_camera_object = renormalized(D * view_.T_camera_object());
  estimate.correlation = Photometry::correlation(constraints_);
  if (level == finest_ && estimate.solved) estimate.deviation = left_open(estimate.sums);
  estimate.score = estimate.merit();
  return estimate;
}

void Tracker::Impl::measure_spread(Estimate& estimate, const OutlineEstimate* outline) {
  const ConstraintSums& sums = estimate.sums;
  estimate.conditioning = conditioning();
  const Camera& level_camera = levels_[static_cast<std::size_t>(finest_drawn_)].camera;
  estimate.stretch =
      observed_stretch(constraints_, level_camera, view_.T_camera_object(), conditioning(), estimate.last_step);
  tile_equations(constraints_.tile_sums(), constraints_.tiles(), equations_);
  if (last_constraints_.elimination) photometry_.eliminate(constraints_, last_constraints_, sums, equations_);
  const Seen motion = finest_drawn_ == finest_ ? seen_motion(sums, finest_) : Seen();
  estimate.seen = motion.seen;
  estimate.hides = motion.hidden > 0;
  Matrix6 A = sums.A;
  if (motion.hidden > 0) {
    A = motion.of(A);
    for (TileEquations& tile : equations_) {
      tile.A = motion.of(tile.A);
      tile.h = motion.seen.transpose() * tile.h;
      tile.to_dark = motion.seen.transpose() * tile.to_dark;
    }
  }
  const double square = observation_square(sums);
  const Matrix6 expectation = square * expectation_information();
  Prior prior{expectation, square * expectation};
  Matrix6 elsewhere = drawing_covariance(conditioning(), level_camera.fx);
  if (options_.motion_blur && moved_) elsewhere += restlessness_.within(look_.exposure);
  const double curvature =
      options_.robust_weights ? robust_curvature(sums.weight / std::max(1.0, sums.rows), kFreedom) : 1;
  const auto covariance = [&] {
    const Matrix6 S = score_covariance(equations_, constraints_.tiles().width, estimate.last_step, A + prior.weight,
                                       look_.optics.lens_variance, block_strip_);
    return Matrix6(pose_covariance(A, curvature, S, prior) + elsewhere);
  };
  estimate.covariance = estimate.texture_covariance = covariance();
  if (!outline) return;
  const Matrix6 said = outline_weight(sums, *outline, motion);
  prior.scores += square * said;
  prior.weight += said;
  estimate.covariance = covariance();
}

Estimate Tracker::Impl::track_once(const Pose& T_predicted) {
  Estimate estimate;
  estimate.T_camera_object = T_predicted;
  {
    const Stopwatch watch(times_.filter);
    image_.enqueue_blur(0, grown(view_.bounds(T_predicted), filter_.radius() + 4));
    device_.impl().queue.flush();  // the device works while the view is drawn
  }
  if (!draw(T_predicted, 0, 1)) return estimate;
  const Stopwatch watch(times_.solve);
  photometry_.start_level(0, view_.planes(0).tiles);
  Pose D = Pose::Identity();
  estimate = iterate(0, D, 1);
  if (estimate.solved) measure_spread(estimate);
  return estimate;
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
    photometry_.start_level(level, view_.planes(level).tiles, level < coarsest ? level + 1 : -1);
    // Right after a frame that was held its light still holds; otherwise it is taken before any step.
    const bool lit = !course_.fresh() && !motion_.lost();
    if (level == coarsest && options_.photometric && !lit) evaluate(level, D);
    estimate = iterate(level, D, options_.iterations);
    if (!estimate.solved) break;
  }
  return estimate;
}

Estimate Tracker::Impl::fine_stage(const Pose& T_start, int coarsest, int lit_level, double most_motion,
                                   const OutlineEstimate* outline) {
  Estimate estimate;
  estimate.T_camera_object = T_start;
  const int finest = finest_;
  for (int redraw = 0; redraw < 2; ++redraw) {
    const Pose T_drawn = estimate.T_camera_object;
    const int top = redraw == 0 ? coarsest : finest;
    if (redraw == 0) {
      const Stopwatch watch(times_.filter);
      const Rect rect = grown(view_.bounds(T_drawn), (filter_.radius() + 4) << top);
      for (int level = finest; level <= top; ++level) image_.enqueue_blur(level, coarser(rect, level));
      device_.impl().queue.flush();  // the device works while the view is drawn
    }
    if (!draw(T_drawn, finest, top - finest + 1)) {
      estimate.solved = false;
      return estimate;
    }
    const Stopwatch watch(times_.solve);
    Pose D = Pose::Identity();
    for (int level = top; level >= finest; --level) {
      // The tiles of the coarse stage's view lie where this view's do, up to a few pixels.
      photometry_.start_level(level, view_.planes(level).tiles, redraw > 0 ? -1 : level < top ? level + 1 : lit_level);
      estimate = iterate(level, D, options_.iterations, most_motion, outline);
      if (!estimate.solved) return estimate;
    }
    if (corner_motion(T_drawn, estimate.T_camera_object) < kRedrawPixels * (1 << finest)) break;
  }
  measure_spread(estimate, outline);
  return estimate;
}

Estimate Tracker::Impl::settled(const Estimate& estimate) {
  Estimate best = estimate;
  for (int i = 0; i < kMostSettling; ++i) {
    const Estimate next = fine_stage(best.T_camera_object, finest_, -1);
    if (!next.solved || next.score < best.score) break;
    const double motion = corner_motion(best.T_camera_object, next.T_camera_object);
    best = next;
    if (motion < kRedrawPixels) break;
  }
  return best;
}

Pose Tracker::Impl::turned(const Pose& T_camera_object, const Eigen::Vector3d& axis, double angle) const {
  Pose result = Pose::Identity();
  result.linear() = Eigen::AngleAxisd(angle, axis) * T_camera_object.linear();
  result.translation() = T_camera_object * p_object_center_ - result.linear() * p_object_center_;
  return renormalized(result);
}

}  // namespace holdfast
