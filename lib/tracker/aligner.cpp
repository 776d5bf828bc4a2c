#include "tracker/aligner.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/round_turns.hpp"
#include "base/stopwatch.hpp"
#include "solve/covariance.hpp"
#include "solve/uncertain_origin.hpp"
#include "tracker/hidden_motions.hpp"

namespace holdfast {
namespace {

/// Steps below this many pixels end the iterations of coarser levels.
constexpr double kConvergedCoarse = 0.4;
/// A view is drawn anew when the pose has moved by more than this many pixels since.
constexpr double kRedrawPixels = 1.5;
/// Longest step of one solution, pixels of the level: rows are linear over about a pixel of blur.
constexpr double kLongestStep = 3;
/// Standard deviation of a start from where nothing is expected, object radii and radians.
constexpr double kFreeDeviation = 0.3;
/// Relative bend of 1/Z at an edge of flat faces.
constexpr double kBend = 6e-4;
/// Iteration from which the contour's edges are searched closest, and steps, pixels, below which they are at once.
constexpr int kClosestFrom = 3;
constexpr double kCloseStep = 0.3;
/// Ratio to what is known without it that the outline's information must reach for some motion to be asked: texture is
/// several times as sure as its equations say (its blocks agree better than that), the outline less than its own.
constexpr double kNoticeable = 0.6;
/// Pixels of the view that a shift is scored with, about: more cost time and change nothing.
constexpr double kScoredPixels = 500;
/// Least information of a shift search's best place beside no shift.
constexpr double kClearShift = 0.02;
constexpr int kMostStride = 4;
/// Weight of the outline beside texture while the object is lost: edges near it may be of what hides it.
constexpr double kWhileLost = 0.05;
/// Pixels with a gradient that are enough of a snapshot: it says less than a texture, and the outline is beside it.
constexpr double kEnoughOfSnapshot = 2000;
/// A snapshot's pose is as sure as one frame's outline, and its turn at least as sure as this share of the outline's
/// information: of a can's turn the outline has less, and that only from its facets.
constexpr double kSnapshotTurn = 0.01;
/// Share of a snapshot's pixels with a gradient on bare objects (cube 0.14, tube 0.05), and on those with something to
/// follow (metal 0.3, clay 0.4, print 0.6).
constexpr double kBareShare = 0.15, kPrintedShare = 0.3;
/// Most pixels dropped at silhouette and depth jumps; thin objects lose one.
constexpr int kSilhouetteMargin = 2;
/// Pixels from the silhouette that a snapshot leaves out: its pose is off by some.
constexpr int kSnapshotMargin = 5;
/// Nominal milliseconds of a view, of one of its pixels, and of one look at texture and at the outline.
constexpr double kViewMs = 0.2, kPixelMs = 1.2e-5, kTextureMs = 0.15, kOutlineMs = 0.3;
/// Iterations on a level where the outline is asked, at most: its edges are searched closer and closer.
constexpr int kContourIterations = 9;

/// Share of the blur's reach that must be known surface where kSilhouetteMargin pixels are dropped at a straight
/// silhouette.
double coverage_at_margin() {
  return 0.5 * std::erfc(-(kSilhouetteMargin + 0.5) / (ImageFilter::kSigma * std::sqrt(2.0))) - 1e-3;
}

double gradient_share(const TextureTerms& terms) { return terms.sums.gradient / std::max(1.0, terms.sums.visible); }

/// Little on an object that has a gradient is as likely shade, or what is in front of it.
void weigh_by_share(TextureTerms& snapshot) {
  const double weight = std::clamp((gradient_share(snapshot) - kBareShare) / (kPrintedShare - kBareShare), 0.0, 1.0);
  snapshot.reliability *= weight;
  snapshot.equations *= weight;
}

/// They are searched closer and closer.
OutlineCloseness search_for(int level, int finest, int iteration, double last_step) {
  if (level > finest || iteration == 0) return {kCoarseSearch, kCoarseEdgeSearch};
  if (iteration < kClosestFrom && last_step > kCloseStep) return {kCloseSearch, kCloseEdgeSearch};
  return {kClosestSearch, kClosestEdgeSearch};
}

}  // namespace

bool is_bare(const TextureTerms& snapshot) { return gradient_share(snapshot) <= kBareShare; }

Aligner::Aligner(const Device::Impl& device, const Mesh& mesh, const std::vector<Level>& levels, const Extent& extent,
                 const Tuning& tuning, ViewTemplate& view, DeviceImage& image)
    : device_(device),
      levels_(levels),
      extent_(extent),
      tuning_(tuning),
      view_(view),
      image_(image),
      texture_(device, levels, extent, tuning),
      round_turns_(round_turns(mesh, extent)),
      shape_(levels, extent, view),
      contour_(device, levels, extent, view, shape_, image),
      edges_(device, levels, extent, mesh, shape_, image),
      shift_search_(device, levels) {}

void Aligner::start_frame(const TrackingState& state, const MotionPrior& prior) {
  prior_ = prior;
  prior_information_ = symmetric_inverse(prior.covariance);
  expected_gradient_pixels_ = state.gradient_pixels;
  texture_.start(state.imaging.texture);
  shape_.start_frame();
  edges_.start_frame();
  times_ = {};
  solved_systems_ = 0;
  nominal_ms_ = 0;
}

double Aligner::corner_motion(const Pose& T_a, const Pose& T_b) const {
  return holdfast::corner_motion(extent_, levels_[0].camera, T_a, T_b);
}

int Aligner::row_stride(int level, const TrackingState& state) const {
  if (tuning_.paper()) return 1;
  const double pixels = expected_gradient_pixels_ / (1 << (2 * (level - state.finest)));
  return std::clamp(
      static_cast<int>(std::lround(pixels / (state.textured ? tuning_.enough_pixels : kEnoughOfSnapshot))), 1,
      kMostStride);
}

ViewRequest Aligner::view_request(const Pose& T_camera_object, int finest, int count, const TrackingState& state,
                                  const ImagingState& imaging, bool across) const {
  ViewRequest request;
  request.T_camera_object = T_camera_object;
  request.finest = finest;
  request.count = count;
  request.grey = image_.grey();
  // Where the margin eats most of a small or thin object, drop less of it.
  const double relaxed = std::clamp((imaging.surviving_share - 0.2) / 0.3, 0.0, 1.0);
  Margin& margin = request.margin;
  margin.least_coverage = 0.6 + (coverage_at_margin() - 0.6) * relaxed;
  if (state.faceted && relaxed > 0.5) margin.bend = kBend;
  margin.jump_reach = relaxed > 0.5 ? kSilhouetteMargin : 1;
  if (tuning_.motion_blur && state.followed() && imaging.exposure.share > 0) {
    const Pose& T_last = state.motion.pose();
    Exposure& exposure = request.exposure;
    exposure.twist = imaging.exposure.share * log_se3(T_camera_object * T_last.inverse());
    exposure.light = imaging.exposure.light;
    exposure.across = across;
    exposure.pixels = imaging.exposure.share * corner_motion(T_last, T_camera_object);
  }
  request.light_texels = imaging.texels.light;
  if (tuning_.shading && imaging.lit) request.shading = imaging.shading.direction();
  return request;
}

bool Aligner::draw(const Pose& T_camera_object, int finest, int count, const TrackingState& state,
                   const ImagingState& imaging, bool across) {
  const Stopwatch watch(times_.filter);
  const bool drawn = view_.enqueue(view_request(T_camera_object, finest, count, state, imaging, across));
  times_.render += view_.render_ms();
  times_.filter -= view_.render_ms();
  const Rect object = view_.bounds(T_camera_object);
  nominal_ms_ += kViewMs + kPixelMs * object.width * object.height / (1 << (2 * finest));
  return drawn;
}

NormalEquations Aligner::prior_equations(const Pose& T_camera_object, const AlignmentPlan& plan,
                                         const Pose& T_start) const {
  if (!plan.expected) {
    const Matrix6 information = Matrix6::Identity() / (kFreeDeviation * kFreeDeviation);
    return {information, information * perturbation_between(T_camera_object, T_start, extent_)};
  }
  // Velocity changes suddenly now and then.
  const Twist off = perturbation_between(T_camera_object, prior_.T_camera_object, extent_);
  const double weight = kept_weight(off.dot(prior_information_ * off));
  return {weight * prior_information_, weight * prior_information_ * off};
}

bool Aligner::spares_contour(const TextureTerms& texture, const NormalEquations& prior,
                             const TrackingState& state) const {
  const Matrix6& contour = state.usual.contour_information;
  if (contour.trace() <= 0) return false;
  const Matrix6 others = texture.equations.A + prior.A;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> solver(contour, others, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()(5) < kNoticeable;
}

void Aligner::shift(Alignment& alignment, int level) {
  const Stopwatch watch(times_.search);
  const int radius = (tuning_.search_radius >> level) + 1;
  const ShiftSearch::Result found =
      shift_search_.search(view_, image_, level, ShiftSearch::within(radius), kScoredPixels);
  if (found.score <= found.unshifted + kClearShift) return;
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const double z = (alignment.T_camera_object * extent_.p_object_center).z();
  alignment.T_camera_object.translation() += Eigen::Vector3d(found.dx * z / camera.fx, found.dy * z / camera.fy, 0);
}

Alignment Aligner::align(const Pose& T_start, const AlignmentPlan& plan, const TrackingState& state) {
  Alignment alignment;
  alignment.T_camera_object = T_start;
  alignment.imaging = state.imaging;
  texture_.photometry().set_object_pair(state.imaging.texture.light);
  for (int redraw = 0; redraw <= plan.redraws; ++redraw) {
    const Pose T_drawn = alignment.T_camera_object;
    const int top = redraw == 0 ? plan.coarsest : plan.finest;
    if (redraw == 0) {
      const Stopwatch watch(times_.filter);
      const Rect rect = grown(view_.bounds(T_drawn), ImageFilter::kMargin << top);
      for (int level = plan.finest; level <= top && state.compares(); ++level) {
        image_.enqueue_blur(level, coarser(rect, level));
      }
      device_.queue.flush();  // the device works while the view is drawn
    }
    if (state.textured && !draw(T_drawn, plan.finest, top - plan.finest + 1, state, state.imaging)) {
      alignment.solved = false;
      return alignment;
    }
    if (redraw == 0 && plan.shift_search && state.textured) shift(alignment, top);
    const Stopwatch watch(times_.solve);
    for (int level = top; level >= plan.finest; --level) {
      if (state.compares()) {
        texture_.start_level(view_, level, redraw > 0 ? -1 : level < top ? level + 1 : plan.light_from);
      }
      iterate(alignment, level, plan, state, T_start);
      if (!alignment.solved) return alignment;
    }
    if (corner_motion(T_drawn, alignment.T_camera_object) < kRedrawPixels * (1 << plan.finest)) break;
  }
  if (plan.measure) measure(alignment, plan, state, T_start);
  return alignment;
}

void Aligner::iterate(Alignment& alignment, int level, const AlignmentPlan& plan, const TrackingState& state,
                      const Pose& T_start) {
  double last_step = 1e9;
  alignment.has_texture = alignment.has_snapshot = alignment.has_contour = alignment.has_edges = false;
  const bool finest = level == state.finest;
  for (int i = 0; i < kContourIterations; ++i) {
    const Pose& T = alignment.T_camera_object;
    NormalEquations equations = prior_equations(T, plan, T_start);
    const OutlineCloseness search = plan.still ? OutlineCloseness{kClosestSearch, kClosestEdgeSearch}
                                               : search_for(level, state.finest, i, last_step);
    const bool outline = plan.contour && tuning_.contour && level <= contour_.coarsest(T, state.finest);
    bool tells = false, spared = false;
    const TextureRequest request{level, state.finest, row_stride(level, state), true,
                                 state.textured && state.left_unobservable};
    if (state.compares()) {
      const Pose D = renormalized(T * view_.T_camera_object().inverse());
      texture_.enqueue(view_, image_, D, request, alignment.imaging.texture);
    }
    if (outline && !state.textured) look_at_outline(alignment, level, search, state);  // while the device compares
    if (state.compares()) {
      TextureTerms& terms = state.textured ? alignment.texture : alignment.snapshot;
      terms = texture_.read(view_, alignment.imaging.texture);
      (state.textured ? alignment.has_texture : alignment.has_snapshot) = true;
      if (!state.textured) weigh_by_share(terms);
      nominal_ms_ += kTextureMs;
      if (level > state.finest || expected_gradient_pixels_ <= 0) {
        expected_gradient_pixels_ = terms.sums.gradient * request.row_stride * (1 << (2 * (level - state.finest)));
      }
      tells = terms.sums.rows >= 6;
      spared = !plan.all && state.textured && tells && spares_contour(terms, equations, state);
      equations += terms.equations;
      if (!state.textured) equations = about_snapshot(equations, state, alignment.snapshot_shift);
    }
    if (outline && !spared) {
      if (state.textured) look_at_outline(alignment, level, search, state);
      tells = tells || alignment.has_contour || alignment.has_edges;
      equations += outline_equations(alignment, state);
    }
    alignment.solved = tells;
    if (!tells) return;
    if (plan.still) break;
    ++solved_systems_;
    Twist y = equations.A.ldlt().solve(equations.h);
    if (!y.allFinite()) {
      alignment.solved = false;
      return;
    }
    alignment.last_step_camera = to_camera_axes(view_.T_camera_object()) * y;
    const Pose T_before = T;
    const double pixels = corner_motion(T_before, perturbed(T_before, y, extent_)) / (1 << level);
    y *= std::min(1.0, kLongestStep / std::max(pixels, 1e-9));
    alignment.T_camera_object = perturbed(T_before, y, extent_);
    last_step = std::min(pixels, kLongestStep);
    if (plan.most_motion < 1e8 && corner_motion(T_start, alignment.T_camera_object) > plan.most_motion) {
      alignment.solved = false;
      return;
    }
    const bool by_outline = alignment.has_contour || alignment.has_edges;
    const bool closest = !by_outline || level > state.finest || &search.contour == &kClosestSearch;
    if (closest && pixels < (finest ? plan.converged : kConvergedCoarse)) break;
    if (!by_outline && i + 1 >= tuning_.iterations) break;
  }
  alignment.score = score(alignment, state, finest ? state.usual.expected_texture_score() : state.usual.coarse_score);
}

void Aligner::look_at_outline(Alignment& alignment, int level, const OutlineCloseness& search,
                              const TrackingState& state) {
  const Stopwatch watch(times_.contour);
  const Pose& T = alignment.T_camera_object;
  nominal_ms_ += kOutlineMs;
  if (tuning_.edges && edges_.has_edges()) {
    alignment.edges = edges_.linearize(T, level, search.edges, state.edges);
    alignment.has_edges = alignment.edges.found;
  }
  if (tuning_.colors && state.colors.known()) {
    alignment.contour = contour_.linearize(T, level, search.contour);
    alignment.has_contour = alignment.contour.found;
  }
}

NormalEquations Aligner::outline_alone(const Alignment& alignment) const {
  NormalEquations outline;
  if (alignment.has_edges) outline += alignment.edges.equations;
  if (alignment.has_contour) outline += alignment.contour.equations;
  return without_turns(outline, round_turns_);
}

NormalEquations Aligner::outline_equations(const Alignment& alignment, const TrackingState& state) const {
  NormalEquations outline = outline_alone(alignment);
  if (!state.textured) return outline;
  outline = without_hidden(outline, alignment.texture, view_.T_camera_object(), round_turns_);
  if (state.motion.lost()) outline *= kWhileLost;
  return outline;
}

NormalEquations Aligner::about_snapshot(const NormalEquations& relative, const TrackingState& state,
                                        Twist& shift) const {
  Matrix6 known = state.usual.outline_information;
  known.diagonal().tail<3>().array() += kSnapshotTurn * known.trace();
  known.diagonal().array() += 1 / (kFreeDeviation * kFreeDeviation);
  return without_origin(relative, known, shift);
}

bool Aligner::take_snapshot(const Pose& T_camera_object, const TrackingState& state) {
  const Stopwatch watch(times_.filter);
  const int count = static_cast<int>(levels_.size()) - state.finest;
  ViewRequest request = view_request(T_camera_object, state.finest, count, state, state.imaging, false);
  request.margin.jump_reach = kSnapshotMargin;
  return view_.enqueue(request, &image_);
}

double Aligner::score(const Alignment& alignment, const TrackingState& state, double usual_texture_score) const {
  const double by_outline = outline_score(alignment, state.usual.outline());
  if (!alignment.has_texture) {
    // Pixels that agree do not make it as usual: where the outline does not fit, other starts are tried.
    return alignment.has_snapshot ? std::max(by_outline, 0.5 * (by_outline + alignment.snapshot.reliability))
                                  : by_outline;
  }
  const double by_texture = alignment.texture.score() / usual_texture_score;
  if (!alignment.has_contour && !alignment.has_edges) return by_texture;
  const double trust = state.usual.texture_trust;
  return trust * by_texture + (1 - trust) * by_outline;
}

void Aligner::measure(Alignment& alignment, const AlignmentPlan& plan, const TrackingState& state,
                      const Pose& T_start) {
  NormalEquations relative = prior_equations(alignment.T_camera_object, plan, T_start);
  if (alignment.has_snapshot) {
    relative += alignment.snapshot.equations;
    Twist shift;
    relative = about_snapshot(relative, state, shift);
  }
  // Motions that do not show are looked for once a frame, where the pose is known.
  if (state.textured && !state.left_unobservable && !tuning_.paper()) {
    texture_.remove_unobservable(view_, plan.finest, alignment.texture);
  }
  if (alignment.has_contour || alignment.has_edges) relative += outline_equations(alignment, state);
  if (!state.textured) {
    alignment.covariance = symmetric_inverse(relative.A);
    return;
  }
  const Camera& camera = levels_[static_cast<std::size_t>(plan.finest)].camera;
  Matrix6 elsewhere =
      drawing_covariance({alignment.T_camera_object * extent_.p_object_center, extent_.radius}, camera.fx);
  if (tuning_.motion_blur && state.followed()) {
    elsewhere += state.motion.within_exposure(alignment.imaging.exposure.share);
  }
  const Matrix6 B = to_camera_axes(alignment.T_camera_object);
  alignment.covariance = texture_.covariance(view_, alignment.texture, alignment.last_step_camera, relative.A) +
                         B.transpose() * elsewhere * B;
}

ExposureFit Aligner::fit(const Pose& T_camera_object, const TrackingState& state, ImagingState imaging, bool across) {
  if (!draw(T_camera_object, state.finest, 1, state, imaging, across)) return {};
  // The cells' light is each view's own: the present view's would speak for it.
  texture_.photometry().set_object_pair(imaging.texture.light);
  texture_.start_level(view_, state.finest);
  const Pose still = Pose::Identity();
  TextureRequest request{state.finest, state.finest, row_stride(state.finest, state), true, false};
  texture_.linearize(view_, image_, still, request, imaging.texture);
  request.learn = false;
  const TextureTerms terms = texture_.linearize(view_, image_, still, request, imaging.texture);
  return {terms.score(), std::sqrt(terms.sums.weighted_square / std::max(1.0, terms.sums.weight))};
}

}  // namespace holdfast
