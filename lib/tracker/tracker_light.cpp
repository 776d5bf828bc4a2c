#include <algorithm>
#include <cmath>
#include <span>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Pixels of an object on which cells are too coarse for its light: without having it drawn it does not fit.
constexpr int kSmall = 4096;
/// Share of the view's gradients that light may make, and what of that it must be below to be drawn again: on what is
/// curved it stays where it is while the surface turns, and what shows little else would seem not to.
constexpr double kMostLight = 0.2, kAgain = 0.7;
/// Light from one side that is not worth that, beside light from everywhere.
constexpr double kLeastDirection = 0.02;

double light_on(const LitPatch& patch, const DrawnLight& drawn) {
  return drawn.lit ? drawn.shading.of(patch.normal) : 1;
}

/// How much brighter the view is drawn than before, with the same tone; 0: nothing tells.
double brighter(std::span<const LitPatch> patches, const DrawnLight& before, const DrawnLight& now) {
  double brighter = 0, weight = 0;
  for (const LitPatch& patch : patches) {
    brighter += patch.weight * light_on(patch, now) / light_on(patch, before);
    weight += patch.weight;
  }
  return weight > 0 ? brighter / weight : 0;
}

/// Brightness of a view that is drawn like `now`, where `before` it was drawn as the patches say.
Photometry::Drawn spread(std::span<const LitPatch> patches, const DrawnLight& before, const DrawnLight& now) {
  double sum = 0, square = 0;
  for (const LitPatch& patch : patches) {
    const double value =
        std::pow(std::pow(patch.drawn, 1 / before.tone) * light_on(patch, now) / light_on(patch, before), now.tone);
    sum += value;
    square += value * value;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, patches.size()));
  return {sum / count, std::sqrt(std::max(0.0, square / count - (sum / count) * (sum / count)))};
}

}  // namespace

template <typename Frame>
void Tracker::Impl::light_first_view(const Frame& frame, const Pose& T_camera_object) {
  const Rect object = view_.bounds(T_camera_object);
  if (!options_.shading || object.empty() || object.width * object.height > kSmall) return;
  const Rect around = grown(object, (filter_.radius() + 4) << finest_);
  {
    const Stopwatch watch(times_.upload);
    image_.enqueue_upload(frame, image_.region(around));
  }
  image_.enqueue_blur(finest_, coarser(around, finest_));
  if (!draw(T_camera_object, finest_, 1)) return;
  photometry_.start_level(finest_, view_.planes(finest_).tiles);
  enqueue_level(finest_, Pose::Identity(), 1);
  learn_shading();
}

template void Tracker::Impl::light_first_view(const ImageView& frame, const Pose& T_camera_object);
template void Tracker::Impl::light_first_view(const DeviceImageView& frame, const Pose& T_camera_object);

void Tracker::Impl::learn_shading() {
  if (!options_.shading || finest_drawn_ != finest_) return;
  const DrawnLight before{look_.shading, look_.lit, look_.tone.drawn()};
  const std::span<const LitPatch> patches =
      lit_patches_.read(view_, occlusion_, finest_, looked_at_every_, photometry_, before);
  look_.shading.learn(patches);
  look_.lit = faceted_ || (look_.shading.direction().norm() > kLeastDirection &&
                           lit_patches_.light_share() < kMostLight * (before.lit ? 1 : kAgain));
  if (options_.tone_curve) look_.tone.learn(patches, look_.shading);
  const DrawnLight now{look_.shading, look_.lit, look_.tone.drawn()};
  if (now.tone == before.tone) {
    if (const double factor = brighter(patches, before, now); factor > 0) photometry_.view_brightened(factor);
  } else {
    course_.usual_gain *= photometry_.view_redrawn(spread(patches, before, before), spread(patches, before, now));
  }
}

}  // namespace holdfast
