#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Score that is enough to be held on to, of itself and of the usual one, and to be found again.
constexpr double kLeastScore = 0.4, kHeldShare = 0.65, kFoundShare = 0.7;
/// Farthest turn from where its motion leads that is believed, radians: silhouettes have look-alikes.
constexpr double kFarthestTurn = 0.4;
/// What makes a surface textured: share of its pixels with at least this gradient (a grey level in [0, 1] a pixel, all
/// channels), of at least as many pixels.
constexpr double kTexturedShare = 0.02, kTexturedGradient = 0.045;
constexpr int kLeastTexturePixels = 100;
/// Pixels that the object is wide at most where that is counted: from nearby any print has soft edges.
constexpr int kTextureSide = 256;
/// How far from where its motion leads an outline that is hard to see is looked for: of how far the object usually
/// strays, and object radii and radians; and its score, of the one without that bound.
constexpr double kStrays = 3, kLeastStray = 0.015, kMostStray = 0.08;
constexpr double kHardlyWorse = 0.9;
/// Share of the outline that may be hidden without a word.
constexpr double kMuchHidden = 0.25;
/// Fewer lines of the outline than this, on the frame, tell no pose.
constexpr double kFewLines = 12;
/// How often colours are learnt anew from a first pose, which may be off, or a frame behind.
constexpr int kFirstLooks = 2;

}  // namespace

void Tracker::Impl::draw_plainly() {
  view_.renderer().set_shading(Eigen::Vector3d::Zero());
  view_.renderer().set_tone(1);
  view_.renderer().set_light_texels(false);
  view_.renderer().set_lens_blur(0);
}

bool Tracker::Impl::shows_texture(const Pose& T_camera_object, bool doubtful) {
  const Rect object = view_.bounds(T_camera_object);
  int level = 0;
  while (level + 1 < options_.levels && std::max(object.width, object.height) >> level > kTextureSide) ++level;
  const Rect rect = coarser(object, level);
  if (rect.empty()) return doubtful;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) * 4);
  draw_plainly();
  view_.renderer().render(T_camera_object, levels_[static_cast<std::size_t>(level)].camera, rect,
                          {rgba.data(), nullptr, rect.width});
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(rect.width);
  int known = 0, textured = 0;
  for (int y = 1; y + 1 < rect.height; ++y) {
    for (int x = 1; x + 1 < rect.width; ++x) {
      const std::uint8_t* p = rgba.data() + y * row + 4 * static_cast<std::ptrdiff_t>(x);
      if (p[3] < 255 || p[3 - 4] < 255 || p[3 + 4] < 255 || p[3 - row] < 255 || p[3 + row] < 255) continue;
      double square = 0;
      for (int c = 0; c < HF_CHANNELS; ++c) {
        const double dx = (p[c + 4] - p[c - 4]) / 510.0, dy = (p[c + row] - p[c - row]) / 510.0;
        square += dx * dx + dy * dy;
      }
      ++known;
      if (square > kTexturedGradient * kTexturedGradient) ++textured;
    }
  }
  return known < kLeastTexturePixels ? doubtful : textured >= kTexturedShare * known;
}

bool Tracker::Impl::shows_texture_elsewhere(const Pose& T_camera_object) {
  constexpr double kQuarter = 1.5707963267948966;
  for (const int axis : {0, 1}) {
    for (const int quarters : {1, 2, 3}) {
      if (shows_texture(turned(T_camera_object, Eigen::Vector3d::Unit(axis), quarters * kQuarter), false)) return true;
    }
  }
  return false;
}

OutlineEstimate Tracker::Impl::outline_estimate(const MotionModel::Hypotheses& hypotheses) {
  OutlineEstimate best;
  for (int i = 0; i < hypotheses.count; ++i) {
    OutlineEstimate next = outline_.estimate(hypotheses.poses[static_cast<std::size_t>(i)], finest_);
    if (i == 0 && next.solved) {
      const bool doubtful = by_outline_ ? outline_memory_.unusually_low(next.score) : jumps(next);
      if (doubtful) next = steadied(next, hypotheses.poses[0]);
    }
    if (i == 0 || (next.solved && next.score > best.score)) best = next;
    if (outline_memory_.fits_as_usual(best.score)) break;
  }
  if (!best.solved) best.T_camera_object = hypotheses.poses[0];
  return best;
}

OutlineEstimate Tracker::Impl::steadied(const OutlineEstimate& estimate, const Pose& T_start) {
  if (!motion_.moving() || motion_.lost()) return estimate;
  const double deviation = kStrays * std::sqrt(course_.usual_stray_squared);
  const OutlineEstimate steady = outline_.estimate(T_start, finest_, std::clamp(deviation, kLeastStray, kMostStray));
  const double least = std::max(kHeldShare * outline_memory_.expected_score(), kHardlyWorse * estimate.score);
  return steady.solved && steady.score > least ? steady : estimate;
}

OutlineEstimate Tracker::Impl::first_outline(const MotionModel::Hypotheses& hypotheses) {
  Pose T_learnt = hypotheses.poses[0];
  for (int i = 0; i < kFirstLooks; ++i) {
    outline_.clear();
    outline_.learn(T_learnt, finest_);
    const OutlineEstimate estimate = outline_estimate(hypotheses);
    if (estimate.solved) T_learnt = estimate.T_camera_object;
  }
  outline_.clear();
  outline_.learn(T_learnt, finest_);
  return outline_estimate(hypotheses);
}

void Tracker::Impl::add_outline_effort() {
  const OutlineStage::Effort effort = outline_.take_effort();
  times_.render += effort.render_ms;
  times_.filter += effort.lines_ms;
  times_.solve += effort.solve_ms;
  solved_systems_ += effort.solved_systems;
}

template <typename Frame>
FrameResult Tracker::Impl::follow_outline(const Frame& frame, const MotionModel::Hypotheses& hypotheses) {
  times_ = {};
  solved_systems_ = 0;
  FrameResult result;
  {
    const Stopwatch total(times_.total);
    Rect wanted;
    for (int i = 0; i < hypotheses.count; ++i) {
      const Rect object = view_.bounds(hypotheses.poses[static_cast<std::size_t>(i)]);
      if (object.empty()) continue;
      wanted = wanted.empty() ? object : united(wanted, object);
    }
    OutlineEstimate best;
    best.T_camera_object = hypotheses.poses[0];
    if (!wanted.empty()) {
      {
        const Stopwatch watch(times_.upload);
        image_.enqueue_upload(frame, image_.region(grown(wanted, outline_.margin())));
      }
      best = outline_.colors_known() ? outline_estimate(hypotheses) : first_outline(hypotheses);
    }
    report_outline(best, result);
    // What an occluder looks like is not to be learnt as the object's.
    if (result.status == Status::held && outline_memory_.fits_as_usual(best.score)) {
      outline_.learn(best.T_camera_object, finest_);
    }
    add_outline_effort();
    result.iterations = solved_systems_;
    outline_memory_.note_score(best.score);
    last_by_outline_ = true;
    course_.T_last = T_shown_ = best.T_camera_object;
  }
  result.ms = times_;
  return result;
}

bool Tracker::Impl::is_expected(const OutlineEstimate& estimate) const {
  return goes_on(motion_.pose(), estimate.T_camera_object, kFarthestTurn) ||
         goes_on(motion_.predicted(), estimate.T_camera_object, kFarthestTurn) ||
         goes_on(motion_.supposed(true), estimate.T_camera_object, kFarthestTurn);
}

bool Tracker::Impl::is_followed(const OutlineEstimate& estimate) const {
  const double share = motion_.lost() ? kFoundShare : kHeldShare;
  const double least = std::max(kLeastScore, share * outline_memory_.expected_score());
  return estimate.solved && estimate.score >= least && is_expected(estimate);
}

void Tracker::Impl::report_outline(const OutlineEstimate& estimate, FrameResult& result) const {
  const OutlineSums& sums = estimate.sums;
  result.by_outline = true;
  result.T_camera_object = estimate.T_camera_object;
  result.visible_pixels = estimate.visible_pixels;
  result.usable_pixels = result.gradient_pixels = static_cast<int>(sums.lines);
  result.passed_pixels = result.rows = static_cast<int>(sums.rows);
  result.used_pixels = static_cast<int>(sums.near);
  result.residual = sums.weight > 0 ? std::sqrt(sums.weighted_square / sums.weight) : 0;
  result.correlation = sums.agreement;
  if (estimate.covariance.trace() > 0) {
    result.information = estimate.conditioning.information(symmetric_inverse(estimate.covariance));
  }
  if (is_followed(estimate)) {
    result.status = Status::held;
    const double hidden = 1 - sums.near / sums.lines;
    if (hidden > kMuchHidden) result.reason = "outline hidden " + std::to_string(std::lround(100 * hidden)) + " %";
  } else if (!estimate.solved && result.visible_pixels <= 0) {
    result.reason = "out of view";
  } else if (!estimate.solved && sums.lines < kFewLines) {
    result.reason = "too little of the outline in view";
  } else if (!estimate.solved) {
    result.reason = "the outline is not found: nothing there stands out from its background";
  } else if (!is_expected(estimate)) {
    result.reason = "the outline fits only where the object could hardly have come to";
  } else {
    result.reason = motion_.lost() ? "lost before, and not surely found again"
                                   : "the outline is not found: occluded, or motion too fast";
  }
}

template <typename Frame>
FrameResult Tracker::Impl::track_outline(const Frame& frame) {
  choose_finest_level();
  const bool colors_known = outline_.colors_known();
  FrameResult result = follow_outline(frame, motion_.hypotheses(options_.predict_velocity, true));
  if (result.status == Status::held) {
    course_.visible_pixels = result.visible_pixels;
    outline_memory_.remember_score(true);
    note_stray(result.T_camera_object);
    motion_.advance(result.T_camera_object, true);
  } else {
    result.T_camera_object = motion_.supposed(options_.predict_velocity);
    motion_.lose();
    if (!colors_known) outline_.clear();  // they are not the object's
  }
  return result;
}

FrameResult Tracker::Impl::refine_outline(const ImageView& frame, const Pose& T_start) {
  MotionModel::Hypotheses start;
  start.poses[0] = T_start;
  start.count = 1;
  const ObjectColors colors = outline_.colors();
  const Course course = course_;
  const MotionModel motion = std::exchange(motion_, MotionModel({p_object_center_, radius_}, true));
  motion_.reset(T_start);
  const FrameResult result = follow_outline(frame, start);
  motion_ = motion;
  course_ = course;
  outline_.set_colors(colors);
  return result;
}

template FrameResult Tracker::Impl::track_outline(const ImageView& frame);
template FrameResult Tracker::Impl::track_outline(const DeviceImageView& frame);

}  // namespace holdfast
