#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Solutions that a way of drawing the view is judged after.
constexpr int kTellingIterations = 3;
/// Motion between frames, pixels, up to which blur by motion that is not drawn is little beside how texels are
/// averaged, and beside a lens's.
constexpr double kTexelMotion = 6, kLensMotion = 4;
/// Held frames between measurements once they are clear.
constexpr int kPause = 64;

/// Frames that a choice is measured in at first; measurements that it is a mean of; what that mean must be to be
/// believed, and to be clear.
constexpr int kFirstMeasurements = 2, kChoiceMemory = 8;
constexpr double kBetter = 0.01, kClear = 0.03;

/// Square pixels between the variances that are compared; where more, a share of the present one.
constexpr double kSoftnessStep = 0.25, kSofterStep = 0.35;
/// Square pixels that are taken for the lens's, and how much of them: noise and compression spoil detail, and least is
/// left over without it.
constexpr double kSoft = 0.25, kLensShare = 0.7;
/// What a soft texture must leave over beside a sharp one to be believed.
constexpr double kClearlySoft = 0.85;
/// Square pixels, more than which nothing is told by.
constexpr double kSoftest = 9;

/// Of the deviation at which texture is faint: above the first share a pose is so unsure that a narrower blur may make
/// it better, below the second so sure that it is not kept; and the weight of a frame in the mean that is compared.
constexpr double kUnsure = 0.1, kSure = 0.05, kUnsureMemory = 0.1;
/// What the narrower blur must leave of the share of gradient pixels used.
constexpr double kKept = 0.85;
/// Scores and shares below it are not divided by.
constexpr double kLeastShare = 1e-3;

/// Counts a frame that a choice can be measured in; whether it is to be.
bool count_frame(Choice& choice) {
  const bool clear = std::abs(choice.evidence) > kClear;
  const int pause = clear ? kPause : choice.measured < kChoiceMemory ? kPause / 16 : kPause / 4;
  return choice.measured < kFirstMeasurements || ++choice.since >= pause;
}

double median(Optics::Softness values, std::size_t count) {
  std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

}  // namespace

void Tracker::Impl::blur_frame(const Pose& T_camera_object, const Optics& optics) {
  const int fine_level = optics.fine_blur.on ? finest_ : -1;
  if (fine_level == filter_.fine_level()) return;
  filter_.set_fine_level(fine_level);
  const Rect rect = grown(view_.bounds(T_camera_object), (filter_.radius() + 4) << finest_);
  image_.enqueue_blur(finest_, coarser(rect, finest_));
}

Estimate Tracker::Impl::refitted(const Pose& T_camera_object, const Optics& optics) {
  look_.optics = optics;
  blur_frame(T_camera_object, optics);
  if (!draw(T_camera_object, finest_, 1)) return {};
  photometry_.fill_missing(finest_, view_.planes(finest_).tiles);
  // Once for its gain and bias. Then at its own best pose: the present one favours the present way.
  evaluate(finest_, Pose::Identity());
  Pose D = Pose::Identity();
  return iterate(finest_, D, kTellingIterations);
}

double Tracker::Impl::left_over(const Pose& T_camera_object, const Optics& optics) {
  const Estimate estimate = refitted(T_camera_object, optics);
  return estimate.solved ? estimate.sums.weighted_square / std::max(1.0, estimate.sums.weight) : 0;
}

void Tracker::Impl::measure_choice(const Pose& T_camera_object, Optics& optics, Choice Optics::*choice, bool stays) {
  Choice& chosen = optics.*choice;
  chosen.since = 0;
  Optics otherwise = optics;
  (otherwise.*choice).on = !chosen.on;
  const double other = left_over(T_camera_object, otherwise), here = left_over(T_camera_object, optics);
  if (other <= 0 || here <= 0) return;
  const double evidence = (chosen.on ? 0.5 : -0.5) * std::log(other / here);
  chosen.measured = std::min(chosen.measured + 1, kChoiceMemory);
  chosen.evidence += (evidence - chosen.evidence) / chosen.measured;
  chosen.on = chosen.evidence > (chosen.on && stays ? -kBetter : kBetter);
}

void Tracker::Impl::measure_lens(const Pose& T_camera_object, Optics& optics) {
  optics.since_lens = 0;
  const auto at = [&](double variance) {
    Optics blurred = optics;
    blurred.lens_variance = variance;
    return left_over(T_camera_object, blurred);
  };
  const std::size_t kept = optics.softness.size();
  const std::size_t known = std::min(static_cast<std::size_t>(optics.softness_measured), kept);
  const double present = known > 0 ? median(optics.softness, known) : 0;
  const double pixel = 1 << 2 * finest_;
  const double step = std::max(kSoftnessStep * pixel, kSofterStep * present);
  const double least = std::max(0.0, present - step);
  const std::array<double, 3> square{at(least), at(least + step), at(least + 2 * step)};
  if (std::min({square[0], square[1], square[2]}) <= 0) return;
  // A parabola through the three. It may have no bottom where one is far off.
  const double bend = square[0] - 2 * square[1] + square[2], slope = 0.5 * (square[2] - square[0]);
  const double steps = bend > 0 ? std::clamp(-slope / bend, -2.0, 2.0) : slope < 0 ? 2.0 : -2.0;
  double told = std::clamp(least + (1 + steps) * step, 0.0, kSoftest);
  // Where much else is left over, a flat one's bottom lies anywhere.
  if (told > kSoft * pixel && at(told) > kClearlySoft * at(0)) told = 0;
  optics.softness[static_cast<std::size_t>(optics.softness_measured++) % kept] = told;
  if (static_cast<std::size_t>(optics.softness_measured) < kept) return;
  const double softness = median(optics.softness, kept);
  optics.lens_variance = softness > kSoft * pixel ? kLensShare * softness : 0;
}

Tracker::Impl::Change Tracker::Impl::measure_blur(const Pose& T_camera_object, Optics& optics) {
  Choice& fine = optics.fine_blur;
  fine.since = 0;
  const auto with = [&](bool on) {
    Optics compared = optics;
    compared.fine_blur.on = on;
    Estimate estimate = refitted(T_camera_object, compared);
    if (estimate.solved) measure_spread(estimate);
    return estimate;
  };
  const Estimate wide = with(false), narrow = with(true);
  if (!wide.solved || !narrow.solved) return {};
  // Of the standard deviation, in the mean over the pose's six degrees of freedom.
  const auto log_deviation = [](const Estimate& e) { return std::log(e.texture_covariance.determinant()) / 12; };
  // What passes the tests no longer is noise, or finer than the texture is.
  const double kept = narrow.used_share() / std::max(kLeastShare, wide.used_share());
  const double evidence = std::min(log_deviation(wide) - log_deviation(narrow), kept - kKept);
  if (!std::isfinite(evidence)) return {};
  fine.measured = std::min(fine.measured + 1, kChoiceMemory);
  fine.evidence += (evidence - fine.evidence) / fine.measured;
  const bool was_on = std::exchange(fine.on, fine.evidence > (fine.on ? 0 : kBetter));
  if (fine.on == was_on) return {};
  const Estimate &before = was_on ? narrow : wide, &after = was_on ? wide : narrow;
  return {after.score / std::max(kLeastShare, before.score),
          after.used_share() / std::max(kLeastShare, before.used_share())};
}

void Tracker::Impl::measure_optics(const Pose& T_camera_object) {
  Optics optics = look_.optics;
  const double motion = corner_motion(motion_.pose(), T_camera_object);
  const bool drawn_as_it_is = look_.exposure_known();
  const bool color = options_.coarse_color && !image_.grey() && (drawn_as_it_is || motion < kTexelMotion);
  const bool texels = textured_ && options_.light_texels && (drawn_as_it_is || motion < kTexelMotion);
  const bool lens = textured_ && options_.lens_blur && (drawn_as_it_is || motion < kLensMotion);
  const bool known = static_cast<std::size_t>(optics.softness_measured) >= optics.softness.size();
  const double deviation = largest_deviation(last_.texture_covariance) / options_.faint_deviation;
  optics.unsureness += kUnsureMemory * (std::min(deviation, 1.0) - optics.unsureness);
  const bool blur = optics.unsureness > kUnsure && options_.fine_blur_sigma < options_.blur_sigma;
  if (optics.unsureness < kSure) optics.fine_blur = {};

  const bool color_due = color && count_frame(optics.coarse_color);
  const bool texels_due = !color_due && texels && count_frame(optics.light_texels);
  const bool lens_due = !color_due && !texels_due && lens && (!known || ++optics.since_lens >= kPause);
  const bool blur_due = !color_due && !texels_due && !lens_due && blur && count_frame(optics.fine_blur);
  if (!color_due && !texels_due && !lens_due && !blur_due) {
    look_.optics = optics;
    return;
  }
  const Appearance before = appearance();
  // How the camera shows the texture tells itself better where noise is blurred more.
  const bool fine = std::exchange(optics.fine_blur.on, optics.fine_blur.on && blur_due);
  Change usual;
  if (color_due) {
    measure_choice(T_camera_object, optics, &Optics::coarse_color, false);
  } else if (texels_due) {
    measure_choice(T_camera_object, optics, &Optics::light_texels, true);
  } else if (lens_due) {
    measure_lens(T_camera_object, optics);
  } else {
    usual = measure_blur(T_camera_object, optics);
  }
  if (!blur_due) optics.fine_blur.on = fine;
  look_.optics = optics;
  // The frame's view is left, and nothing else of what was tried.
  blur_frame(T_camera_object, optics);
  if (draw(T_camera_object, finest_, 1)) {
    photometry_.start_level(finest_, view_.planes(finest_).tiles);
    evaluate(finest_, Pose::Identity());
    evaluate(finest_, Pose::Identity());
  }
  restore(before);
  look_.optics = optics;
  look_.usual_fine_score *= usual.score;
  look_.confirmed_score *= usual.score;
  course_.usual_share *= usual.share;
}

}  // namespace holdfast
