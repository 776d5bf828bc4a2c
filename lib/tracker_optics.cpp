#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "tracker_impl.hpp"

namespace holdfast {
namespace {

/// Solutions that a way of drawing the view is judged after.
constexpr int kTellingIterations = 3;
/// Motion between frames, pixels, up to which blur by motion that is not drawn is little beside how texels are
/// averaged, and beside a lens's.
constexpr double kTexelMotion = 6, kLensMotion = 4;
/// Held frames between measurements once they are clear.
constexpr int kPause = 64;

/// Frames that how texels are averaged is measured in at first; measurements that it is a mean of; what that mean must
/// be to be believed, and to be clear.
constexpr int kTexelMeasurements = 2, kTexelMemory = 8;
constexpr double kBetterTexels = 0.01, kClearTexels = 0.03;

/// Square pixels between the variances that are compared; where more, a share of the present one.
constexpr double kSoftnessStep = 0.25, kSofterStep = 0.35;
/// Square pixels that are taken for the lens's, and how much of them: noise and compression spoil detail, and least is
/// left over without it.
constexpr double kSoft = 0.45, kLensShare = 0.7;
/// Square pixels, more than which nothing is told by.
constexpr double kSoftest = 9;

double median(Look::Softness values, std::size_t count) {
  std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

}  // namespace

double Tracker::Impl::left_over(const Pose& T_camera_object, bool light_texels, double lens_variance) {
  const bool light_texels_before = std::exchange(look_.light_texels, light_texels);
  const double lens_variance_before = std::exchange(look_.lens_variance, lens_variance);
  double square = 0;
  if (draw(T_camera_object, finest_, 1)) {
    // Once for its gain and bias. Then at its own best pose: the present one favours the present way.
    evaluate(finest_, Pose::Identity());
    Pose D = Pose::Identity();
    const Estimate estimate = iterate(finest_, D, kTellingIterations);
    if (estimate.solved) square = estimate.sums.weighted_square / std::max(1.0, estimate.sums.weight);
  }
  look_.light_texels = light_texels_before;
  look_.lens_variance = lens_variance_before;
  return square;
}

void Tracker::Impl::measure_texels(const Pose& T_camera_object) {
  const bool present = look_.light_texels;
  const double other = left_over(T_camera_object, !present, look_.lens_variance);
  const double here = left_over(T_camera_object, present, look_.lens_variance);
  if (other <= 0 || here <= 0) return;
  const double evidence = (present ? 0.5 : -0.5) * std::log(other / here);
  look_.light_measured = std::min(look_.light_measured + 1, kTexelMemory);
  look_.light_evidence += (evidence - look_.light_evidence) / look_.light_measured;
  if ((present ? -1 : 1) * look_.light_evidence > kBetterTexels) look_.light_texels = !present;
}

void Tracker::Impl::measure_lens(const Pose& T_camera_object) {
  const std::size_t kept = look_.softness.size();
  const std::size_t known = std::min(static_cast<std::size_t>(look_.softness_measured), kept);
  const double present = known > 0 ? median(look_.softness, known) : 0;
  const double pixel = 1 << 2 * finest_;
  const double step = std::max(kSoftnessStep * pixel, kSofterStep * present);
  const double least = std::max(0.0, present - step);
  std::array<double, 3> square{};
  for (std::size_t i = 0; i < square.size(); ++i) {
    square[i] = left_over(T_camera_object, look_.light_texels, least + static_cast<double>(i) * step);
    if (square[i] <= 0) return;
  }
  // A parabola through the three. It may have no bottom where one is far off.
  const double bend = square[0] - 2 * square[1] + square[2], slope = 0.5 * (square[2] - square[0]);
  const double steps = bend > 0 ? std::clamp(-slope / bend, -2.0, 2.0) : slope < 0 ? 2.0 : -2.0;
  look_.softness[static_cast<std::size_t>(look_.softness_measured++) % kept] =
      std::clamp(least + (1 + steps) * step, 0.0, kSoftest);
  if (static_cast<std::size_t>(look_.softness_measured) < kept) return;
  const double softness = median(look_.softness, kept);
  look_.lens_variance = softness > kSoft * pixel ? kLensShare * softness : 0;
}

void Tracker::Impl::measure_optics(const Estimate& estimate) {
  // Not in the first frame, which takes long enough.
  if (!textured_ || course_.gradient_pixels <= 0) return;
  const double motion = corner_motion(motion_.pose(), estimate.T_camera_object);
  const bool drawn_as_it_is = look_.exposure_settled >= 3;
  const bool texels = options_.light_texels && (drawn_as_it_is || motion < kTexelMotion);
  const bool lens = options_.lens_blur && (drawn_as_it_is || motion < kLensMotion);

  const bool clear = std::abs(look_.light_evidence) > kClearTexels;
  const int texel_pause = clear ? kPause : look_.light_measured < kTexelMemory ? kPause / 16 : kPause / 4;
  if (texels && (look_.light_measured < kTexelMeasurements || ++look_.since_texels >= texel_pause)) {
    measure_texels(estimate.T_camera_object);
    look_.since_texels = 0;
  } else if (lens && (static_cast<std::size_t>(look_.softness_measured) < look_.softness.size() ||
                      ++look_.since_lens >= kPause)) {
    measure_lens(estimate.T_camera_object);
    look_.since_lens = 0;
  } else {
    return;
  }
  // Others read what is left of this frame.
  if (draw(estimate.T_camera_object, finest_, 1)) evaluate(finest_, Pose::Identity());
}

}  // namespace holdfast
