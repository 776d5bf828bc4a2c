#include <algorithm>
#include <cmath>
#include <utility>

#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

constexpr int kMostThinning = 4;  ///< every fourth row
/// Of what passed in the frame before, what passes so suddenly that the vote is taken again.
constexpr double kFewPass = 0.8;
/// Looser tests on coarse levels: radians, share of the larger gradient, share of the neighbourhood.
constexpr double kCoarseAngle = 0.8, kCoarseDifference = 0.8, kCoarseVote = 0.5;
/// Pixels from the last frame's pose, within which what was looked at last is that.
constexpr double kSameLook = 0.5;
constexpr double kNeverSaturated = 2;
constexpr double kLeastScale = 0.004, kMostScale = 0.1;

}  // namespace

Conditioning Tracker::Impl::conditioning() const { return {view_.T_camera_object() * p_object_center_, radius_}; }

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
  k.vote_share =
      static_cast<float>(tests_of(level).vote_share * (options_.occlusion.vote_relative ? look_.passing_share : 1));
  k.robust = options_.robust_weights ? 1 : 0;
  k.inverse_scale2 = static_cast<float>(1.0 / (look_.scale[l] * look_.scale[l]));
  k.freedom = static_cast<float>(kFreedom);
  k.mean_gradient = options_.mean_gradient ? 1 : 0;
  k.redundancy = options_.redundancy ? 1 : 0;
  k.redundancy_cosine2 = static_cast<float>(options_.redundancy_cosine * options_.redundancy_cosine);
  k.gradient_minimum2 = static_cast<float>(options_.occlusion.gradient_minimum * options_.occlusion.gradient_minimum);
  k.saturated = static_cast<float>(options_.mode == Mode::paper ? kNeverSaturated : kSaturated);
  return k;
}

OcclusionOptions Tracker::Impl::tests_of(int level) const {
  OcclusionOptions tests = options_.occlusion;
  if (level > finest_) {
    tests.angle_maximum = std::max(tests.angle_maximum, kCoarseAngle);
    tests.difference_relative = std::max(tests.difference_relative, kCoarseDifference);
    tests.vote_share = std::min(tests.vote_share, kCoarseVote);
  }
  return tests;
}

int Tracker::Impl::thinning(int level) const {
  if (options_.mode == Mode::paper) return 1;
  const double known = course_.fresh() ? first_gradient_pixels_ : course_.gradient_pixels;
  const double pixels = known / (1 << (2 * (level - finest_)));
  return std::clamp(static_cast<int>(std::lround(pixels / options_.enough_pixels)), 1, kMostThinning);
}

kernel::hf_constraints Tracker::Impl::enqueue_level(int level, const Pose& D, int every) {
  const auto l = static_cast<std::size_t>(level);
  photometry_.enqueue_upload(level, view_.planes(level).tiles);
  auto warp = make_warp(levels_[l].camera, D, conditioning().p_camera_center, image_.valid(level));
  warp.every = every;
  looked_at_every_ = every;
  kernel::hf_tests tests = make_tests(tests_of(level), image_.grey());
  tests.keep_gradients = options_.mean_gradient ? 1 : 0;
  occlusion_.enqueue(view_, image_, level, warp, tests, photometry_.buffer(level));
  kernel::hf_constraints options = constraint_options(level);
  options.every = every;
  // A coarse level's cells are too large for their middles to stand for them: what is eliminated could exceed A.
  options.elimination = level == finest_ && photometry_.eliminates() ? 1 : 0;
  constraints_.enqueue(view_, occlusion_, level, options, photometry_.buffer(level));
  decided_ = level == finest_drawn_;
  return options;
}

void Tracker::Impl::look_at_last() {
  const Pose T_looked_at = renormalized(D_last_ * view_.T_camera_object());
  if (!last_.solved || (decided_ && corner_motion(T_looked_at, last_.T_camera_object) < kSameLook)) return;
  if (!draw(last_.T_camera_object, finest_, 1)) return;
  D_last_ = Pose::Identity();
  photometry_.start_level(finest_, view_.planes(finest_).tiles);
  enqueue_level(finest_, D_last_, 1);
}

void Tracker::Impl::decide_all_pixels() {
  if (!decided_ || looked_at_every_ == 1 || view_.planes(finest_drawn_).tiles.width == 0) return;
  enqueue_level(finest_drawn_, D_last_, 1);
}

ConstraintSums Tracker::Impl::sums_at(int level, const Pose& D) {
  D_last_ = D;
  last_constraints_ = enqueue_level(level, D, thinning(level));
  ConstraintSums sums = constraints_.read();
  if (options_.occlusion.block_vote && options_.occlusion.vote_relative && level == finest_) {
    const double before = std::exchange(look_.passing_share, constraints_.passing_share());
    if (look_.passing_share < kFewPass * before) {
      // It moves as it did not before: by the last frame's share nearly all that passes would be outvoted.
      last_constraints_.vote_share = constraint_options(level).vote_share;
      constraints_.enqueue(view_, occlusion_, level, last_constraints_, photometry_.buffer(level));
      sums = constraints_.read();
    }
  }
  if (level > finest_ || first_gradient_pixels_ <= 0) {
    first_gradient_pixels_ = sums.gradient * looked_at_every_ * (1 << (2 * (level - finest_)));
  }
  sums.A_rows = sums.A;
  if (last_constraints_.elimination) photometry_.eliminate(constraints_, last_constraints_, sums);
  sums.scale = look_.scale[static_cast<std::size_t>(level)];
  return sums;
}

ConstraintSums Tracker::Impl::evaluate(int level, const Pose& D) {
  const ConstraintSums sums = sums_at(level, D);
  photometry_.update(level, constraints_);
  if (options_.robust_weights && sums.rows > 0) {
    look_.scale[static_cast<std::size_t>(level)] =
        std::clamp(std::sqrt(sums.weighted_square / sums.rows), kLeastScale, kMostScale);
  }
  return sums;
}

}  // namespace holdfast
