#include "holdfast/tracker.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/stopwatch.hpp"
#include "holdfast/error.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Of the size at which a level is left, the one at which it is taken again.
constexpr double kSmaller = 0.8;
constexpr double kScoreMemory = 0.2;  ///< weight of a new score
/// Pixels that the prediction may be off, of a frame and of the one before, to go to the finest level without a
/// coarser.
constexpr double kMostSurprise = 2;
double most_surprise(int finest) { return kMostSurprise * (1 << finest); }
/// Weight of a new frame in the share of texture that is usually seen.
constexpr double kShareMemory = 0.02;
/// Pixels from where its motion leads, beyond which a pose is as doubtful as after a loss.
constexpr double kSurprise = 15;
/// A pose within this many radians and object radii of the last frame's may be the same object moving on.
constexpr double kSameTurn = 0.15, kSamePlace = 1.5;
/// What is seen in part is believed at once where the object was lost or would have gone, turned by no more than these
/// radians; elsewhere after the picture was searched for everything else.
constexpr double kNearTurn = 0.4;

const Mesh& validated(const Mesh& mesh, const TrackerOptions& options) {
  mesh.validate();
  if (!mesh.has_appearance() && !options.outline) {
    throw Error(ErrorCode::model,
                "the model has neither texture nor vertex colours, so there is nothing to compare with the frame; give "
                "it a texture first ('holdfast bake' makes one from frames with poses), or follow its outline (option "
                "outline, not in paper mode)");
  }
  return mesh;
}

const Camera& validated(const Camera& camera) {
  camera.validate();
  return camera;
}

/// Shifts that one search may score: by the option's radius, or, to recover, over a whole coarse picture.
std::size_t most_shifts(const std::vector<Level>& levels, const TrackerOptions& options) {
  const auto side = static_cast<std::size_t>(2 * (options.search_radius + 1) + 1);
  const Level& coarse = levels[std::min<std::size_t>(1, levels.size() - 1)];
  return std::max(side * side, static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
}

/// A caller's frame is read only during the call, however that ends.
class FrameInUse {
 public:
  explicit FrameInUse(DeviceImage& image) : image_(image) {}
  ~FrameInUse() { image_.wait_for_upload(); }
  FrameInUse(const FrameInUse&) = delete;
  FrameInUse& operator=(const FrameInUse&) = delete;

 private:
  DeviceImage& image_;
};

const TrackerOptions& validated(const TrackerOptions& options) {
  options.validate();
  return options;
}

/// Made first of all, while the device may still be loading its kernels.
Renderer renderer_for(const Mesh& mesh, const Camera& camera, const TrackerOptions& options) {
  const std::vector<Level> levels = make_levels(validated(camera), validated(options).levels);
  return view_renderer(
      validated(mesh, options), levels,
      {options.texture_samples, options.mesh_deviation, options.shading, options.outline, options.light_texels});
}

}  // namespace

Tracker::Impl::Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device)
    : Impl(mesh, camera, options, device, renderer_for(mesh, camera, options)) {}

Tracker::Impl::Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device,
                    Renderer renderer)
    : camera_(camera),
      options_(options),
      device_(device),
      levels_(make_levels(camera, options.levels)),
      p_object_center_(mesh.center().cast<double>()),
      radius_(mesh.radius()),
      filter_(device.impl(), options.blur_sigma, options.fine_blur_sigma),
      view_(device.impl(), mesh, std::move(renderer), levels_, filter_),
      image_(device.impl(), camera, levels_, filter_),
      occlusion_(device.impl(), levels_),
      constraints_(device.impl(), levels_),
      search_(device.impl(), levels_, most_shifts(levels_, options)),
      photometry_(device.impl(), levels_, options.photometric),
      outline_(device.impl(), levels_, {p_object_center_, radius_}, view_, image_),
      motion_({p_object_center_, radius_}, expects_motion()),
      lit_patches_(device.impl(), levels_),
      keyframes_(p_object_center_) {
  finest_ = options.finest_level;
  has_appearance_ = mesh.has_appearance();
  by_outline_ = !has_appearance_;
  faceted_ = options_.shading && has_flat_faces(mesh);
  textured_ = std::any_of(mesh.materials.begin(), mesh.materials.end(),
                          [](const Material& material) { return !material.texture.empty(); });
  equations_.reserve(static_cast<std::size_t>(levels_[0].tiles_x()) * static_cast<std::size_t>(levels_[0].tiles_y()));
  places_.reserve(kAppearancesAFrame + kMostPlaces);
  last_places_.reserve(kMostPlaces);
  warm_up();
}

void Tracker::Impl::choose_finest_level() {
  int level = options_.finest_level;
  const auto many = [&](int at_level) {
    // Once coarser, the object must become clearly smaller to be seen in full again.
    return options_.most_pixels * (at_level < finest_ ? kSmaller : 1.0) * (1 << (2 * at_level));
  };
  while (options_.mode != Mode::paper && level + 1 < options_.levels && course_.visible_pixels > many(level)) ++level;
  if (level == finest_) return;
  course_.gradient_pixels = 0;
  look_.usual_fine_score = 0;
  look_.optics.fine_blur = {};
  finest_ = level;
}

void Tracker::Impl::prepare_frame() {
  choose_finest_level();
  moved_ = !motion_.lost() && expects_motion();
}

void Tracker::Impl::set_blur() { filter_.set_fine_level(look_.optics.fine_blur.on && !motion_.lost() ? finest_ : -1); }

bool Tracker::Impl::goes_directly() const {
  // A first pose may be as good as a prediction.
  const bool expected = course_.fresh() || (motion_.moving() && course_.prediction_error <= most_surprise(finest_));
  return expected && !motion_.lost();
}

void Tracker::Impl::remember_score(const Estimate& good) {
  look_.usual_fine_score += (look_.usual_fine_score > 0 ? kScoreMemory : 1) * (good.score - look_.usual_fine_score);
}

template <typename Frame>
bool Tracker::Impl::follow_directly(const Frame& frame, const Pose& T_predicted, Estimate& best) {
  if (!goes_directly()) return false;
  const int finest = finest_;
  const double most = most_surprise(finest);
  const Rect object = view_.bounds(T_predicted);
  if (object.empty()) return false;
  {
    const Stopwatch watch(times_.upload);
    const int margin = ((filter_.radius() + 4) << finest) + static_cast<int>(2 * most);
    image_.enqueue_upload(frame, image_.region(grown(object, margin)));
  }
  const Estimate estimate = fine_stage(T_predicted, finest, -1, most);
  if (!is_good(estimate) || estimate.score < kUsualScore * look_.expected_score() ||
      corner_motion(T_predicted, estimate.T_camera_object) > most) {
    return false;
  }
  best = estimate;
  if (options_.motion_blur) measure_exposure(best);
  remember_score(best);
  return true;
}

template <typename Frame>
Estimate Tracker::Impl::follow_fully(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope,
                                     bool search) {
  const Starts starts = coarse_starts(hypotheses, scope, search);
  Estimate best = best_from(starts, hypotheses, scope, search);
  bool elsewhere = false;
  if (options_.recovery && search && !is_good(best)) {
    const Rect whole = image_.region({0, 0, camera_.width, camera_.height});
    // Not only in the first frame of a loss: it may be the outline that was lost then.
    if (!std::exchange(course_.searching, true)) {
      keyframes_.plan(motion_.pose());
      last_places_.clear();
    }
    if (!motion_.lost()) {
      const Stopwatch watch(times_.upload);
      image_.enqueue_upload(frame, whole);
    }
    const auto take_better = [&](const Estimate& found_there) {
      if (found_there.score <= best.score) return;
      best = found_there;
      elsewhere = true;
    };
    if (motion_.goes_on_unseen()) take_better(found_in_parts(motion_.predicted()));
    if (!is_good(best)) take_better(found_anywhere(whole));
  }
  if ((motion_.lost() || elsewhere) && is_probable(best)) best = settled(best);
  if (options_.motion_blur && moved_ && is_good(best)) measure_exposure(best);
  if (is_good(best)) {
    if (scope.coarse() && !elsewhere) {
      look_.usual_score += kScoreMemory * (starts.best().score - look_.usual_score);
    }
    remember_score(best);
  }
  return best;
}

template <typename Frame>
bool Tracker::Impl::follow_textured(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope,
                                    bool search, Estimate& best, OutlineEstimate& outline) {
  if (course_.faint && !motion_.lost()) {
    return follow_faint(frame, hypotheses, scope, search, nullptr, best, outline);
  }
  // After a loss texture is looked for everywhere first: it alone may tell how the object is turned.
  const Appearance before = appearance();
  const Estimate searched = best = follow_fully(frame, hypotheses, scope, search);
  if (is_good(searched)) {
    if (course_.faint && outline_.colors_known()) best = beside_outline(searched, false, outline);
    return false;
  }
  if (!course_.faint) {
    if (!search || !outline_.colors_known() || motion_.lost()) return false;
    // Texture that was little has been lost at once.
    const Stopwatch watch(times_.upload);
    image_.enqueue_upload(frame, outline_region(scope));
    course_.faint = true;
  }
  restore(before);  // what fits nowhere does not tell how the object looks
  return follow_faint(frame, hypotheses, scope, search, &searched, best, outline);
}

template <typename Frame>
FrameResult Tracker::Impl::follow(const Frame& frame, const MotionModel::Hypotheses& hypotheses, bool search) {
  times_ = {};
  solved_systems_ = 0;
  first_gradient_pixels_ = 0;
  photometry_.forget_cells();
  set_blur();
  FrameResult result;
  Estimate best;
  best.T_camera_object = hypotheses.poses[0];
  {
    const Stopwatch total(times_.total);
    if (course_.fresh() && !motion_.lost()) light_first_view(frame, hypotheses.poses[0]);
    const bool direct = search && !course_.faint && follow_directly(frame, hypotheses.poses[0], best);
    const Scope scope = direct ? Scope{} : this->scope(hypotheses, search);
    OutlineEstimate outline;
    bool by_outline = false;
    if (!direct && scope.wanted.empty()) forget_view();
    if (!scope.wanted.empty()) {
      {
        const Stopwatch watch(times_.upload);
        image_.enqueue_upload(frame, course_.faint ? outline_region(scope) : scope.region);
      }
      if (options_.mode == Mode::paper) {
        best = track_once(hypotheses.poses[0]);
        if (expects_motion() && is_good(best)) remember_score(best);
      } else {
        by_outline = follow_textured(frame, hypotheses, scope, search, best, outline);
      }
    }
    last_ = best;
    outline_memory_.note_score(outline.score);
    last_by_outline_ = by_outline;
    if (by_outline) {
      report_outline_of_textured(outline, result);
    } else {
      result.T_camera_object = best.T_camera_object;
      report(best, result);
    }
    if (result.status == Status::held && !by_outline && best.used_share() > kUsualScore * course_.usual_share) {
      proportions_.add(best.stretch);
    }
    course_.last_promising = by_outline || is_promising(best);
    const bool again = course_.probable_frames > 0 && goes_on(course_.T_last, result.T_camera_object, kSameTurn);
    course_.probable_frames = !by_outline && is_probable(best) ? (again ? course_.probable_frames + 1 : 1) : 0;
    course_.T_last = T_shown_ = result.T_camera_object;
  }
  result.iterations = solved_systems_;
  result.ms = times_;
  return result;
}

double Tracker::Impl::stray(const Pose& T_camera_object) const {
  const Conditioning at_object{T_camera_object * p_object_center_, radius_};
  return at_object.conditioned(log_se3(T_camera_object * motion_.predicted().inverse())).norm();
}

void Tracker::Impl::note_stray(const Pose& T_camera_object) {
  if (!motion_.moving() || motion_.lost()) return;
  const double strayed = stray(T_camera_object);
  course_.usual_stray_squared += kScoreMemory * (strayed * strayed - course_.usual_stray_squared);
}

bool Tracker::Impl::goes_on(const Pose& T_from, const Pose& T_to, double turn) const {
  const Pose motion = T_to * T_from.inverse();
  const Eigen::Vector3d p_from = T_from * p_object_center_;
  return rotation_angle(motion.linear()) < turn && (motion * p_from - p_from).norm() < kSamePlace * radius_;
}

Standing Tracker::Impl::standing(const Estimate& estimate) const {
  Standing result;
  result.lost_before = motion_.lost();
  result.surprising = moved_ && corner_motion(motion_.predicted(), estimate.T_camera_object) > kSurprise;
  result.usual_share = course_.usual_share;
  result.hides_usually = course_.hides_usually();
  // A part of the object may look like another part.
  result.expected = goes_on(motion_.pose(), estimate.T_camera_object, kNearTurn) ||
                    goes_on(motion_.predicted(), estimate.T_camera_object, kNearTurn) ||
                    (course_.probable_frames * kAppearancesAFrame >= keyframes_.planned() &&
                     goes_on(course_.T_last, estimate.T_camera_object, kSameTurn));
  return result;
}

void Tracker::Impl::report(const Estimate& estimate, FrameResult& result) const {
  const ConstraintSums& sums = estimate.sums;
  result.visible_pixels = static_cast<int>(sums.visible) * estimate.looked_at_every << (2 * finest_);
  result.usable_pixels = static_cast<int>(sums.usable);
  result.gradient_pixels = static_cast<int>(sums.gradient);
  result.passed_pixels = static_cast<int>(sums.passed);
  result.used_pixels = static_cast<int>(sums.used);
  result.rows = static_cast<int>(sums.rows);
  result.residual = sums.weight > 0 ? std::sqrt(sums.weighted_square / sums.weight) : 0;
  result.correlation = estimate.correlation;
  if (estimate.covariance.trace() > 0) {
    result.information = estimate.conditioning.information(symmetric_inverse(estimate.covariance));
  }
  Circumstances circumstances;
  static_cast<Standing&>(circumstances) = standing(estimate);
  circumstances.searched_everywhere = options_.recovery && motion_.lost() && options_.mode != Mode::paper;
  if (moved_) {
    const double motion = corner_motion(motion_.pose(), estimate.T_camera_object);
    circumstances.blur_pixels = look_.exposure * motion;
    circumstances.predicted_pixels = motion_.moving() ? corner_motion(motion_.pose(), motion_.predicted()) : 0;
  }
  circumstances.misfit = proportions_.misfit();
  circumstances.gain = photometry_.gain(1) / course_.usual_gain;
  Verdict verdict = judge(estimate, options_, circumstances);
  result.status = verdict.status;
  result.reason = std::move(verdict.reason);
}

void Tracker::Impl::restore(const Appearance& before) {
  photometry_.set_object_pair(before.light);
  look_ = before.look;
}

template <typename Frame>
FrameResult Tracker::Impl::track(const Frame& frame) {
  if (!started_) {
    throw Error(ErrorCode::invalid_argument, "track() before reset(): the tracker has no first pose");
  }
  image_.check(frame);  // before anything is taken for seen
  if (by_outline_) return track_outline(frame);
  prepare_frame();  // before what is kept is kept: scores of another level mean nothing
  const Appearance before = appearance();
  const bool colors_known = outline_.colors_known();
  expect();
  FrameResult result = follow(frame, hypotheses(), searches());
  if (result.status == Status::held) {
    note_stray(result.T_camera_object);
    course_.searching = false;
  }
  if (result.status == Status::held && result.by_outline) {
    {
      const Stopwatch watch(times_.total);
      note_outline_of_textured(result);
    }
    result.ms = times_;
    restore(before);
    restlessness_.interrupt();
    motion_.advance(result.T_camera_object, true,
                    moved_to(result.T_camera_object, spread_.covariance(), conditioning()));
  } else if (result.status == Status::held) {
    const Pose T_moved_to = moved_to(result.T_camera_object, last_.covariance, last_.conditioning);
    look_.confirmed_frames = std::max(0, look_.confirmed_frames - 1);
    const bool fresh = course_.fresh();  // takes long enough
    course_.visible_pixels = result.visible_pixels;
    course_.gradient_pixels = static_cast<double>(result.gradient_pixels) * last_.looked_at_every;
    look_.surviving_share =
        std::min(1.0, static_cast<double>(result.usable_pixels) * (last_.looked_at_every << (2 * finest_)) /
                          std::max(1, result.visible_pixels));
    course_.prediction_error =
        motion_.moving() ? corner_motion(motion_.predicted(), result.T_camera_object) : Course::kUnknown;
    const double share = result.used_pixels / std::max(1.0, static_cast<double>(result.gradient_pixels));
    // What is seen when nothing is in front: rises at once, falls slowly.
    course_.usual_share = std::max(share, course_.usual_share + kShareMemory * (share - course_.usual_share));
    course_.hides = last_.hides;
    course_.usual_hides +=
        std::max(1.0 / ++course_.held_frames, kShareMemory) * ((last_.hides ? 1 : 0) - course_.usual_hides);
    course_.usual_gain += kScoreMemory * (photometry_.gain(1) - course_.usual_gain);
    const bool as_usual = look_.usual_fine_score > 0 && last_.score > kUsualScore * look_.usual_fine_score;
    if (as_usual) {
      learn_shading();
      keyframes_.remember(result.T_camera_object);
    }
    {
      const Stopwatch watch(times_.total);
      if (moved_ && !fresh && options_.mode != Mode::paper) measure_optics(result.T_camera_object);
      judge_texture(last_);
    }
    result.ms = times_;
    if (motion_.moving() && !motion_.lost()) {
      restlessness_.add(
          conditioning().conditioned(log_se3(result.T_camera_object * motion_.steadily_predicted().inverse())));
    } else {
      restlessness_.interrupt();
    }
    motion_.advance(result.T_camera_object, as_usual, T_moved_to);
  } else {
    restore(before);
    if (!colors_known) outline_.clear();  // they are not the object's
    const Pose T_supposed = motion_.supposed(options_.predict_velocity);
    motion_.lose();
    if (course_.last_promising) {
      motion_.suspect(result.T_camera_object);  // a better guess than that it went on as it moved
    } else {
      result.T_camera_object = T_supposed;
    }
  }
  return result;
}

FrameResult Tracker::Impl::refine(const ImageView& frame, const Pose& T_start) {
  validate_pose(T_start);
  image_.check(frame);
  if (by_outline_ || (options_.outline && !shows_texture(T_start))) return refine_outline(frame, T_start);
  MotionModel::Hypotheses start;
  start.poses[0] = T_start;
  start.count = 1;
  const Appearance before = appearance();
  moved_ = false;
  expected_ = false;
  const Course course = course_;
  course_.faint = false;
  const Proportions proportions = proportions_;
  // Judged as a pose that was given, not as one to be found again.
  const MotionModel motion = std::exchange(motion_, MotionModel({p_object_center_, radius_}, expects_motion()));
  motion_.reset(T_start);
  FrameResult result = follow(frame, start, false);
  course_ = course;
  proportions_ = proportions;
  motion_ = motion;
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
                "the pose puts the object out of the picture of " + std::to_string(impl_->camera_.width) + "x" +
                    std::to_string(impl_->camera_.height) +
                    " pixels; check the camera's focal length and centre, and the pose's unit (metres) and axes (x "
                    "right, y down, z forward)");
  }
  impl_->ahead_.reset();
  impl_->keyframes_.clear();
  impl_->motion_.reset(renormalized(T_camera_object));
  impl_->motion_filter_.clear();
  impl_->restlessness_.clear();
  impl_->proportions_.clear();
  impl_->photometry_.reset();
  impl_->look_ = {};
  const bool textured = impl_->has_appearance_ && (!impl_->options_.outline || impl_->shows_texture(T_camera_object));
  impl_->by_outline_ = !textured && !(impl_->has_appearance_ && impl_->shows_texture_elsewhere(T_camera_object));
  impl_->outline_.clear();
  impl_->outline_memory_.clear();
  impl_->course_ = {};
  impl_->course_.faint = !textured;
  impl_->spread_.clear();
  impl_->finest_ = impl_->options_.finest_level;
  impl_->started_ = true;
}

FrameResult Tracker::track(const ImageView& frame) {
  return with_device_errors("tracking a frame", [&] {
    const FrameInUse in_use(impl_->image_);
    return impl_->track(frame);
  });
}

FrameResult Tracker::track(const DeviceImageView& frame) {
  return with_device_errors("tracking a frame", [&] {
    const FrameInUse in_use(impl_->image_);
    return impl_->track(frame);
  });
}

void Tracker::draw_ahead() {
  with_device_errors("drawing ahead", [&] { impl_->draw_ahead(); });
}

FrameResult Tracker::refine(const ImageView& frame, const Pose& T_camera_object) {
  return with_device_errors("refining a pose", [&] {
    const FrameInUse in_use(impl_->image_);
    return impl_->refine(frame, T_camera_object);
  });
}

void Tracker::set_texture(std::size_t material, const Texture& texture) {
  impl_->ahead_.reset();
  impl_->view_.renderer().set_texture(material, texture);
  impl_->textured_ = impl_->textured_ || !texture.empty();
  impl_->has_appearance_ = impl_->has_appearance_ || !texture.empty();
}

const Camera& Tracker::camera() const { return impl_->camera_; }
const TrackerOptions& Tracker::options() const { return impl_->options_; }

std::string Tracker::description() const {
  const DeviceInfo& info = impl_->device_.info();
  return info.name + " (" + info.platform + ", " + (impl_->device_.impl().strips ? "strips" : "groups") + "), " +
         impl_->view_.renderer().description();
}

}  // namespace holdfast
