#include "holdfast/tracker.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "device_image.hpp"
#include "flow_constraints.hpp"
#include "holdfast/error.hpp"
#include "motion_model.hpp"
#include "occlusion.hpp"
#include "photometry.hpp"
#include "shift_search.hpp"
#include "solver.hpp"
#include "view_template.hpp"

namespace holdfast {
namespace {

/// Least side of the object on a level that is still worth comparing there, pixels.
constexpr double kLeastSide = 20;
/// Steps below this many pixels of the level end a level's iterations; each step is about a quarter of the one before.
constexpr double kConvergedPixels = 0.1, kConvergedPixelsCoarse = 0.4;
/// A view is drawn anew when the pose has moved by more than this many pixels since.
constexpr double kRedrawPixels = 1.5;
/// Longest step of one solution, pixels of the level.
constexpr double kLongestStep = 3;
/// Share of the usual coarse score that a hypothesis must reach to be believed unchallenged; weight of a new score.
constexpr double kUsualScore = 0.8, kScoreMemory = 0.2;
/// Pixels that are enough for a pose; of larger objects every second to fourth row is looked at.
constexpr double kEnoughPixels = 6000, kEnoughPixelsCoarse = 8000;
constexpr int kMostThinning = 4;
/// What it takes to be found again after a loss: share of gradient pixels used, correlation.
constexpr double kFoundShare = 0.4, kFoundCorrelation = 0.85;
constexpr double kDamping = 1e-6;
/// Looser tests on coarse levels: radians, share of the larger gradient, share of the neighbourhood.
constexpr double kCoarseAngle = 0.8, kCoarseDifference = 0.8, kCoarseVote = 0.5;
constexpr double kFreedom = 4;  ///< of Student's t
constexpr double kLeastScale = 0.004, kMostScale = 0.1, kFirstScale = 0.05;

/// Share of the blur's reach that must be known surface when `margin` pixels are dropped at a straight silhouette.
double coverage_at_margin(int margin, double sigma) {
  if (margin <= 0 || sigma <= 0) return 0.5;
  return 0.5 * std::erfc(-(margin + 0.5) / (sigma * std::sqrt(2.0))) - 1e-3;
}

class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    total_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_;
  std::chrono::steady_clock::time_point start_;
};

const Mesh& validated(const Mesh& mesh) {
  mesh.validate();
  if (!mesh.has_appearance()) {
    throw Error(ErrorCode::model,
                "the model has neither texture nor vertex colours, so there is nothing to compare with the frame; give "
                "it a texture first ('holdfast bake' makes one from frames with poses)");
  }
  return mesh;
}

const Camera& validated(const Camera& camera) {
  camera.validate();
  return camera;
}

const TrackerOptions& validated(const TrackerOptions& options) {
  options.validate();
  return options;
}

}  // namespace

struct Tracker::Impl {
  Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device);

  template <typename Frame>
  FrameResult track(const Frame& frame);
  FrameResult refine(const ImageView& frame, const Pose& T_start);

  /// A pose with what speaks for it.
  struct Estimate {
    Pose T_camera_object = Pose::Identity();
    double score = -1;
    bool solved = false;
    ConstraintSums sums;
    double correlation = 0;
  };

  template <typename Frame>
  FrameResult follow(const Frame& frame, const MotionModel::Hypotheses& hypotheses, bool search);
  Estimate track_once(const Pose& T_predicted);
  Estimate coarse_stage(const Pose& T_start, bool search, int coarsest, int finest);
  Estimate fine_stage(const Pose& T_start, int coarsest, bool lit_by_coarse_stage);
  /// One pass of tests, constraints and sums at D, without moving.
  ConstraintSums evaluate(int level, const Pose& D);
  /// Enqueues tests and constraints of every `thinning`th row.
  kernel::hf_constraints enqueue_level(int level, const Pose& D, int thinning);
  /// Large objects have more pixels than a pose needs: every how manieth row to look at.
  int thinning(int level) const;
  /// Decides every pixel of the last view again, at its last pose.
  void decide_all_pixels();
  /// Thresholds of a level: where the motion is not known yet, gradients differ by it.
  OcclusionOptions tests_of(int level) const;
  /// Iterates on the view that is drawn; returns the last sums.
  Estimate iterate(int level, Pose& D, int iterations);
  bool draw(const Pose& T_camera_object, int finest, int count);
  kernel::hf_constraints constraint_options(int level) const;
  Conditioning conditioning() const;
  double corner_motion(const Pose& T_a, const Pose& T_b) const;
  /// Held; to be found again after a loss takes more than to be held on to.
  bool is_good(const Estimate& estimate) const;
  void judge(const Estimate& estimate, FrameResult& result) const;

  Camera camera_;
  TrackerOptions options_;
  Device device_;
  std::vector<Level> levels_;
  Eigen::Vector3d p_object_center_;
  double radius_;
  ImageFilter filter_;
  ViewTemplate view_;
  DeviceImage image_;
  OcclusionTest occlusion_;
  FlowConstraints constraints_;
  ShiftSearch search_;
  Photometry photometry_;
  MotionModel motion_;
  std::vector<double> scale_;
  double surviving_share_ = 1;  ///< of the visible pixels, off the margin, on the finest level of the last frame
  bool started_ = false;
  Pose D_last_ = Pose::Identity();  ///< of the last sums, from the view that is drawn
  StageTimes times_;
  int solved_systems_ = 0;
  int finest_drawn_ = 0;
  double usual_score_ = 1;  ///< of the coarse stage, running mean

  /// What a frame that was not held must not change.
  struct Appearance {
    Photometry::ObjectPair light;
    std::array<double, 6> scale{};
    double usual_score = 1, surviving_share = 1;
  };
  Appearance appearance() const;
  void restore(const Appearance& appearance);
};

Tracker::Impl::Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device)
    : camera_(validated(camera)),
      options_(validated(options)),
      device_(device),
      levels_(make_levels(camera, options.levels)),
      p_object_center_(mesh.center().cast<double>()),
      radius_(mesh.radius()),
      filter_(device.impl(), options.blur_sigma),
      view_(device.impl(), validated(mesh), camera, levels_, filter_),
      image_(device.impl(), camera, levels_, filter_),
      occlusion_(device.impl(), levels_),
      constraints_(device.impl(), levels_),
      search_(device.impl(), levels_, std::max(1, options.search_radius)),
      photometry_(device.impl(), levels_, options.photometric),
      motion_(p_object_center_),
      scale_(levels_.size(), kFirstScale) {
  device_.impl().queue.finish();
}

Conditioning Tracker::Impl::conditioning() const { return {view_.T_camera_object() * p_object_center_, radius_}; }

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
  const bool drawn = view_.enqueue(T_camera_object, finest, count, image_.grey(), margin);
  times_.render += view_.render_ms();
  times_.filter -= view_.render_ms();
  finest_drawn_ = finest;
  return drawn;
}

kernel::hf_constraints Tracker::Impl::constraint_options(int level) const {
  const auto l = static_cast<std::size_t>(level);
  const Conditioning condition = conditioning();
  kernel::hf_constraints k{};
  for (int i = 0; i < 3; ++i) k.center[i] = static_cast<float>(condition.p_camera_center(i));
  k.radius = static_cast<float>(condition.radius);
  k.fx = static_cast<float>(levels_[l].camera.fx);
  k.fy = static_cast<float>(levels_[l].camera.fy);
  k.cx = static_cast<float>(levels_[l].camera.cx);
  k.cy = static_cast<float>(levels_[l].camera.cy);
  k.block_vote = options_.occlusion.block_vote ? 1 : 0;
  k.vote_radius = std::max(1, HF_VOTE_RADIUS - level);
  k.vote_share = static_cast<float>(tests_of(level).vote_share);
  k.robust = options_.robust_weights ? 1 : 0;
  k.inverse_scale2 = static_cast<float>(1.0 / (scale_[l] * scale_[l]));
  k.freedom = static_cast<float>(kFreedom);
  k.mean_gradient = options_.mean_gradient ? 1 : 0;
  k.redundancy = options_.redundancy ? 1 : 0;
  k.redundancy_cosine2 = static_cast<float>(options_.redundancy_cosine * options_.redundancy_cosine);
  return k;
}

OcclusionOptions Tracker::Impl::tests_of(int level) const {
  OcclusionOptions tests = options_.occlusion;
  if (level > options_.finest_level) {
    tests.angle_maximum = std::max(tests.angle_maximum, kCoarseAngle);
    tests.difference_relative = std::max(tests.difference_relative, kCoarseDifference);
    tests.vote_share = std::min(tests.vote_share, kCoarseVote);
  }
  return tests;
}

int Tracker::Impl::thinning(int level) const {
  if (options_.mode == Mode::paper) return 1;
  const Rect object = view_.bounds(view_.T_camera_object());
  const double pixels = 0.6 * object.width * object.height / (1 << (2 * level));
  return std::clamp(static_cast<int>(std::lround(pixels / (level > options_.finest_level ? kEnoughPixelsCoarse : kEnoughPixels))), 1, kMostThinning);
}

kernel::hf_constraints Tracker::Impl::enqueue_level(int level, const Pose& D, int every) {
  const auto l = static_cast<std::size_t>(level);
  photometry_.enqueue_upload(level, view_.planes(level).tiles);
  auto warp = make_warp(levels_[l].camera, D, conditioning().p_camera_center, image_.valid(level));
  warp.every = every;
  occlusion_.enqueue(view_, image_, level, warp, make_tests(tests_of(level), image_.grey()), photometry_.buffer(level));
  kernel::hf_constraints options = constraint_options(level);
  options.every = every;
  constraints_.enqueue(view_, occlusion_, level, options, photometry_.buffer(level));
  return options;
}

void Tracker::Impl::decide_all_pixels() {
  if (thinning(finest_drawn_) == 1 || view_.planes(finest_drawn_).tiles.width == 0) return;
  enqueue_level(finest_drawn_, D_last_, 1);
}

ConstraintSums Tracker::Impl::evaluate(int level, const Pose& D) {
  const auto l = static_cast<std::size_t>(level);
  D_last_ = D;
  const kernel::hf_constraints options = enqueue_level(level, D, thinning(level));
  ConstraintSums sums = constraints_.read();
  photometry_.eliminate(constraints_, options, sums);
  photometry_.update(level, constraints_);
  if (options_.robust_weights && sums.rows > 0) {
    scale_[l] = std::clamp(std::sqrt(sums.weighted_square / sums.rows), kLeastScale, kMostScale);
  }
  return sums;
}

Tracker::Impl::Estimate Tracker::Impl::iterate(int level, Pose& D, int iterations) {
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
    if (motion < (level > options_.finest_level ? kConvergedPixelsCoarse : kConvergedPixels)) break;
  }
  estimate.T_camera_object = renormalized(D * view_.T_camera_object());
  estimate.correlation = Photometry::correlation(constraints_);
  // Pixels that left the sampled region speak against an estimate too.
  estimate.score = estimate.sums.used / std::max(1.0, estimate.sums.gradient) * estimate.sums.usable /
                   std::max(1.0, estimate.sums.visible) * std::max(0.0, estimate.correlation);
  return estimate;
}

Tracker::Impl::Estimate Tracker::Impl::track_once(const Pose& T_predicted) {
  Estimate estimate;
  estimate.T_camera_object = T_predicted;
  if (!draw(T_predicted, 0, 1)) return estimate;
  {
    const Stopwatch watch(times_.filter);
    image_.enqueue_blur(0, grown(view_.bounds(T_predicted), filter_.radius() + 4));
  }
  const Stopwatch watch(times_.solve);
  photometry_.start_level(0, view_.planes(0).tiles, false);
  Pose D = Pose::Identity();
  return iterate(0, D, 1);
}

Tracker::Impl::Estimate Tracker::Impl::coarse_stage(const Pose& T_start, bool search, int coarsest, int finest) {
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

Tracker::Impl::Estimate Tracker::Impl::fine_stage(const Pose& T_start, int coarsest, bool lit_by_coarse_stage) {
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
      for (int level = finest; level <= top; ++level) image_.enqueue_blur(level, coarser(rect, level));
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

template <typename Frame>
FrameResult Tracker::Impl::follow(const Frame& frame, const MotionModel::Hypotheses& hypotheses, bool search) {
  times_ = {};
  solved_systems_ = 0;
  FrameResult result;
  Estimate best;
  best.T_camera_object = hypotheses.poses[0];
  {
    const Stopwatch total(times_.total);
    Rect wanted;
    for (int i = 0; i < hypotheses.count; ++i)
      wanted = united(wanted, view_.bounds(hypotheses.poses[static_cast<std::size_t>(i)]));
    const Rect object = view_.bounds(hypotheses.poses[0]);
    const double side = std::sqrt(0.6 * object.width * object.height);
    int coarsest = 0;
    while (coarsest + 1 < options_.levels && side / (2 << coarsest) >= kLeastSide) ++coarsest;
    coarsest = std::max(coarsest, options_.finest_level);
    const int margin =
        ((filter_.radius() + 4) << coarsest) + (search ? options_.search_radius : 0) + static_cast<int>(0.1 * side);
    const Rect region = image_.region(grown(wanted, margin));
    if (!wanted.empty()) {
      {
        const Stopwatch watch(times_.upload);
        image_.enqueue_upload(frame, region);
      }
      if (options_.mode == Mode::paper) {
        best = track_once(hypotheses.poses[0]);
      } else {
        const int coarse_finest = std::max(coarsest - 1, options_.finest_level);
        const bool coarse = coarsest > options_.finest_level;
        // Starts of the fine stage, the most promising first.
        std::array<Estimate, 8> starts;
        std::size_t start_count = 0;
        const auto add_start = [&](const Estimate& estimate) {
          std::size_t place = start_count++;
          for (; place > 0 && starts[place - 1].score < estimate.score; --place) starts[place] = starts[place - 1];
          starts[place] = estimate;
        };
        if (coarse) {
          {
            const Stopwatch watch(times_.filter);
            for (int level = coarse_finest; level <= coarsest; ++level) {
              image_.enqueue_blur(level, coarser(region, level));
            }
            if (search) search_.enqueue_gradients(image_, coarsest);
            device_.impl().queue.flush();  // the device works while the first view is drawn
          }
          for (int i = 0; i < hypotheses.count; ++i) {
            const Estimate estimate =
                coarse_stage(hypotheses.poses[static_cast<std::size_t>(i)], search, coarsest, coarse_finest);
            add_start(estimate);
            // A first hypothesis that fits as well as usual needs no second.
            if (!motion_.lost() && estimate.solved && estimate.score > kUsualScore * usual_score_) break;
          }
        }
        // Where the coarse levels see too little, the plain prediction may still be the better start.
        for (int i = 0; i < hypotheses.count; ++i) {
          Estimate plain;
          plain.T_camera_object = hypotheses.poses[static_cast<std::size_t>(i)];
          add_start(plain);
        }
        for (std::size_t i = 0; i < start_count; ++i) {
          const Estimate estimate =
              fine_stage(starts[i].T_camera_object, i == 0 && starts[0].score > 0 ? options_.finest_level : std::max(coarse_finest - 1, options_.finest_level),
                         coarse && coarse_finest > options_.finest_level);
          if (i == 0 || estimate.score > best.score) best = estimate;
          if (is_good(best)) break;
        }
        if (coarse && is_good(best)) usual_score_ += kScoreMemory * (starts[0].score - usual_score_);
      }
    }
    result.T_camera_object = best.T_camera_object;
    judge(best, result);
  }
  result.iterations = solved_systems_;
  result.ms = times_;
  return result;
}

bool Tracker::Impl::is_good(const Estimate& estimate) const {
  const double used_share = estimate.sums.used / std::max(1.0, estimate.sums.gradient);
  const bool lost = motion_.lost();
  return estimate.solved && used_share >= (lost ? kFoundShare : options_.lost_visible_share) &&
         estimate.correlation >= (lost ? kFoundCorrelation : options_.lost_correlation);
}

void Tracker::Impl::judge(const Estimate& estimate, FrameResult& result) const {
  const ConstraintSums& sums = estimate.sums;
  result.visible_pixels = static_cast<int>(sums.visible);
  result.usable_pixels = static_cast<int>(sums.usable);
  result.gradient_pixels = static_cast<int>(sums.gradient);
  result.passed_pixels = static_cast<int>(sums.passed);
  result.used_pixels = static_cast<int>(sums.used);
  result.rows = static_cast<int>(sums.rows);
  result.residual = sums.weight > 0 ? std::sqrt(sums.weighted_square / sums.weight) : 0;
  result.correlation = estimate.correlation;
  const double scale2 = sums.rows > 0 ? std::max(sums.weighted_square / sums.rows, 1e-8) : 1.0;
  if (sums.rows > 0) result.information = conditioning().information(sums.A / scale2);
  const double used_share = sums.used / std::max(1.0, sums.gradient);
  result.status = Status::lost;
  if (sums.visible <= 0) {
    result.reason = "out of view";
  } else if (sums.gradient < 20) {
    result.reason = "no texture in view";
  } else if (!estimate.solved) {
    result.reason = "too few constraints left";
  } else if (used_share < options_.lost_visible_share) {
    result.reason = "occluded or moved too fast";
  } else if (result.correlation < options_.lost_correlation) {
    result.reason = "the frame does not look like the model";
  } else if (!is_good(estimate)) {
    result.reason = "lost before, and not surely found again";
  } else {
    result.status = Status::held;
  }
}

Tracker::Impl::Appearance Tracker::Impl::appearance() const {
  Appearance state;
  state.light = photometry_.object_pair();
  std::copy(scale_.begin(), scale_.end(), state.scale.begin());
  state.usual_score = usual_score_;
  state.surviving_share = surviving_share_;
  return state;
}

void Tracker::Impl::restore(const Appearance& state) {
  photometry_.set_object_pair(state.light);
  std::copy(state.scale.begin(), state.scale.begin() + static_cast<std::ptrdiff_t>(scale_.size()), scale_.begin());
  usual_score_ = state.usual_score;
  surviving_share_ = state.surviving_share;
}

template <typename Frame>
FrameResult Tracker::Impl::track(const Frame& frame) {
  if (!started_) {
    throw Error(ErrorCode::invalid_argument, "track() before reset(): the tracker has no first pose");
  }
  const bool search = options_.correlation_search && options_.mode == Mode::standard;
  const Appearance before = appearance();
  FrameResult result =
      follow(frame, motion_.hypotheses(options_.predict_velocity, options_.mode == Mode::standard), search);
  if (result.status == Status::held) {
    surviving_share_ = std::min(
        1.0, static_cast<double>(result.usable_pixels) / std::max(1, result.visible_pixels));
    motion_.advance(result.T_camera_object);
  } else {
    restore(before);
    motion_.lose();
    result.T_camera_object = motion_.pose();
  }
  return result;
}

FrameResult Tracker::Impl::refine(const ImageView& frame, const Pose& T_start) {
  validate_pose(T_start);
  MotionModel::Hypotheses start;
  start.poses[0] = T_start;
  start.count = 1;
  const Appearance before = appearance();
  FrameResult result = follow(frame, start, false);
  restore(before);
  return result;
}

Tracker::Tracker(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device)
    : impl_(with_device_errors("preparing the tracker",
                               [&] { return std::make_unique<Impl>(mesh, camera, options, device); })) {}

Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

void Tracker::reset(const Pose& T_camera_object) {
  validate_pose(T_camera_object);
  const Eigen::Vector3d p_camera = T_camera_object * impl_->p_object_center_;
  if (p_camera.z() <= 0) {
    throw Error(ErrorCode::pose, "the pose puts the object behind the camera (z = " + std::to_string(p_camera.z()) +
                                     " m); poses map object to camera coordinates, z forward");
  }
  if (impl_->view_.bounds(T_camera_object).empty()) {
    throw Error(ErrorCode::pose,
                "the pose puts the object out of view; check the camera's focal length and the pose's "
                "unit (metres) and axes (x right, y down, z forward)");
  }
  impl_->motion_.reset(renormalized(T_camera_object));
  impl_->photometry_.reset();
  impl_->usual_score_ = 1;
  impl_->surviving_share_ = 1;
  std::fill(impl_->scale_.begin(), impl_->scale_.end(), kFirstScale);
  impl_->started_ = true;
}

FrameResult Tracker::track(const ImageView& frame) {
  return with_device_errors("tracking a frame", [&] { return impl_->track(frame); });
}

FrameResult Tracker::track(const DeviceImageView& frame) {
  return with_device_errors("tracking a frame", [&] { return impl_->track(frame); });
}

FrameResult Tracker::refine(const ImageView& frame, const Pose& T_camera_object) {
  return with_device_errors("refining a pose", [&] { return impl_->refine(frame, T_camera_object); });
}

PixelMask Tracker::pixel_mask() const {
  return with_device_errors("reading the pixel mask", [&] {
    Impl& impl = *impl_;
    impl.decide_all_pixels();
    const int level_index = impl.finest_drawn_;
    const Level& level = impl.levels_[static_cast<std::size_t>(level_index)];
    const auto& tiles = impl.view_.planes(level_index).tiles;
    PixelMask mask;
    mask.width = impl.camera_.width;
    mask.height = impl.camera_.height;
    mask.classes.assign(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height), 0);
    std::vector<std::uint8_t> classes(level.elements);
    impl.device_.impl().queue.enqueueReadBuffer(impl.constraints_.classes(level_index), CL_TRUE, 0, classes.size(),
                                                classes.data());
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        const int lx = x >> level_index, ly = y >> level_index;
        if (lx < tiles.x * HF_TILE || ly < tiles.y * HF_TILE || lx >= (tiles.x + tiles.width) * HF_TILE ||
            ly >= (tiles.y + tiles.height) * HF_TILE) {
          continue;
        }
        mask.classes[static_cast<std::size_t>(y * mask.width + x)] =
            classes[static_cast<std::size_t>(level.layout.origin + ly * level.layout.stride + lx)];
      }
    }
    return mask;
  });
}

RenderedView Tracker::rendered_view() const {
  Impl& impl = *impl_;
  RenderedView view;
  view.width = impl.camera_.width;
  view.height = impl.camera_.height;
  view.T_camera_object = impl.view_.T_camera_object();
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  view.rgba.assign(count * 4, 0);
  view.depth.assign(count, 1.0f);
  const DepthRange range =
      impl.view_.renderer().render(view.T_camera_object, impl.levels_[0].camera, {0, 0, view.width, view.height},
                                   {view.rgba.data(), view.depth.data(), 0});
  const double near_plane = range.near_plane, far_plane = range.far_plane;
  for (float& depth : view.depth) {
    depth = depth < 1.0f ? static_cast<float>(near_plane * far_plane /
                                              (far_plane - static_cast<double>(depth) * (far_plane - near_plane)))
                         : 0.0f;
  }
  return view;
}

void Tracker::set_texture(std::size_t material, const Texture& texture) {
  impl_->view_.renderer().set_texture(material, texture);
}

const Camera& Tracker::camera() const { return impl_->camera_; }
const TrackerOptions& Tracker::options() const { return impl_->options_; }

std::string Tracker::description() const {
  const DeviceInfo& info = impl_->device_.info();
  return info.name + " (" + info.platform + ", " + (impl_->device_.impl().strips ? "strips" : "groups") + "), " +
         impl_->view_.renderer().description();
}

}  // namespace holdfast
