// What is expected of the next pose, and what that counts beside the rows.
#include <algorithm>

#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Pixels that share their noise and three channels: rows that count as one observation.
constexpr double kRowsPerObservation = 40;
/// How far a start may be off where nothing is expected, and how far objects usually stray from where one is: object
/// radii and radians, standard deviation.
constexpr double kFreeDeviation = 0.3, kStrayDeviation = 0.05;

}  // namespace

void Tracker::Impl::expect() {
  if (moved_) {
    motion_filter_.predict();
  } else {
    motion_filter_.clear();
  }
  expected_ = moved_ && motion_.moving() && options_.predict_velocity && options_.expected_motion;
  if (!expected_) return;
  T_expected_ = motion_.predicted();
  expected_information_ = symmetric_inverse(motion_filter_.pose_covariance());
}

Pose Tracker::Impl::moved_to(const Pose& T_camera_object, const Matrix6& covariance, const Conditioning& condition) {
  if (covariance.trace() <= 0) {  // nothing has told of it yet
    motion_filter_.clear();
    return T_camera_object;
  }
  const Matrix6 gain = motion_filter_.update(covariance);
  Pose T_moved_to = T_camera_object;
  if (expected_) {
    const Twist off = condition.conditioned(log_se3(T_camera_object * T_expected_.inverse()));
    T_moved_to = renormalized(exp_se3(condition.twist(gain * off)) * T_expected_);
  }
  const Matrix6 moving = motion_filter_.rest();
  if (moving.isIdentity(0)) return T_moved_to;
  const Twist velocity = condition.conditioned(log_se3(T_moved_to * motion_.pose().inverse()));
  return renormalized(exp_se3(condition.twist(moving * velocity)) * motion_.pose());
}

Matrix6 Tracker::Impl::expectation_information() const {
  return expected_ ? expected_information_ : Matrix6(Matrix6::Identity() / (kFreeDeviation * kFreeDeviation));
}

double Tracker::Impl::observation_square(const ConstraintSums& sums) const {
  const bool grey = image_.grey();
  return (grey ? kRowsPerObservation / HF_CHANNELS : kRowsPerObservation) * sums.weighted_square /
         std::max(1.0, sums.rows);
}

Matrix6 Tracker::Impl::outline_weight(const ConstraintSums& sums, const OutlineEstimate& outline,
                                      const Seen& motion) const {
  Matrix6 information = outline.information;
  for (int i = 0; i < motion.hidden; ++i) {
    if (hides(outline, motion.hidden_motions.col(i))) forget(information, motion.hidden_motions.col(i));
  }
  return observation_square(sums) / outline_memory_.excess() * information;
}

Seen Tracker::Impl::seen_motion(const ConstraintSums& sums, int level) const {
  if (options_.mode == Mode::paper) return {};
  // Away from where it fits more is left over than noise.
  const double left_over = sums.weighted_square / std::max(1.0, sums.weight);
  const double noise_square = course_.fresh() ? left_over : std::min(left_over, sums.scale * sums.scale);
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  // With light eliminated by cells' middles A may be less than nothing along motions that the rows do show.
  return holdfast::seen_motion(sums.A_rows,
                               noise_information(constraints_.tile_sums(), constraints_.tiles(), camera, conditioning(),
                                                 noise_square, image_.grey() ? 1 : HF_CHANNELS));
}

ConstraintSums Tracker::Impl::with_expectation(ConstraintSums sums, const Pose& D, const Seen& motion,
                                               const OutlineEstimate* outline) const {
  if (sums.rows < 6 || !expects_motion()) return sums;
  if (motion.hidden > 0) {
    sums.A = motion.of(sums.A);
    sums.h = motion.seen.transpose() * sums.h;
  }
  // Without an expectation the view drawn is one, a weak one: what the constraints leave free stays as it is.
  const Pose to_expected =
      D.inverse() * (expected_ ? T_expected_ * view_.T_camera_object().inverse() : Pose::Identity());
  const Matrix6 weight = observation_square(sums) * expectation_information();
  sums.A += weight;
  sums.h += weight * conditioning().conditioned(log_se3(to_expected));
  if (outline) {
    const Matrix6 said = outline_weight(sums, *outline, motion);
    sums.A += said;
    sums.h += said * conditioning().conditioned(
                         log_se3(D.inverse() * outline->T_camera_object * view_.T_camera_object().inverse()));
  }
  return sums;
}

double Tracker::Impl::left_open(const ConstraintSums& sums) const {
  const double deviation = expected_ ? kStrayDeviation : kFreeDeviation;
  return posterior_deviation(sums.A, observation_square(sums) / (deviation * deviation), deviation);
}

}  // namespace holdfast
