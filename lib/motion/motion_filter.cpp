#include "motion/motion_filter.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/turns.hpp"
#include "solve/covariance.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {
namespace {

/// Standard deviation of a first pose and of an unknown velocity (a frame): object radii and radians.
constexpr double kFirstPose = 0.1, kGivenPose = 0.01, kUnknownVelocity = 0.3;
/// Standard deviation of the velocity's change in a frame, before innovations tell it, and its bounds.
constexpr double kChange = 0.05, kLeastChange = 0.05, kMostChange = 0.15;
/// Weight of a new innovation.
constexpr double kInnovationMemory = 0.1;
/// A lost object goes on as it moved for so many frames, then is taken to have stopped.
constexpr double kGoesOnFor = 12;
/// Share of a change of velocity that the next one is expected to be.
constexpr double kGoesOnChanging = 0.75;
/// Times the median change of velocity that is a sudden one, and a change too large to go on: object radii, radians.
constexpr double kSudden = 2, kLargeChange = 0.05;
/// Standard deviation of a pose above which nothing has told of a motion for long: its velocity is let go.
constexpr double kOpen = 0.2, kMostDeviation = 1;

/// What velocities are made of: the way of the centre, object radii, and the turn, radians, in the axes of T_from. Not
/// perturbation_between(), whose centre moves along the turn's screw.
Twist displacement(const Pose& T_from, const Pose& T_to, const Extent& extent) {
  const Eigen::Matrix3d R = T_from.linear();
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(R.transpose() * T_to.linear()));
  Twist result;
  result << R.transpose() * (T_to * extent.p_object_center - T_from * extent.p_object_center) / extent.radius,
      turn.angle() * turn.axis();
  return result;
}

}  // namespace

void MotionFilter::reset(const Pose& T_camera_object) {
  const Extent extent = extent_;
  *this = MotionFilter(extent);
  T_ = T_camera_object;
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = kFirstPose * kFirstPose * Matrix6::Identity();
  covariance_.bottomRightCorner<6, 6>() = kUnknownVelocity * kUnknownVelocity * Matrix6::Identity();
  usual_innovation_squared_ = kChange * kChange;
}

void MotionFilter::begin(double t) {
  covariance_.topLeftCorner<6, 6>() = kGivenPose * kGivenPose * Matrix6::Identity();
  t_ = t;
  started_ = true;
  updates_ = 1;
}

double MotionFilter::going_on(double t) const {
  const double dt = started_ ? t - t_ : step_;
  return misses_ > 0 ? std::min(dt, kGoesOnFor * step_) : dt;
}

Pose MotionFilter::gone_on(double dt, bool changing) const {
  Eigen::Vector3d v = velocity_, w = angular_velocity_;
  if (changing) {
    v += kGoesOnChanging * velocity_change_;
    w += kGoesOnChanging * angular_change_;
  }
  const Eigen::Vector3d turn = dt * w;
  return renormalized(anchored(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * T_.linear(),
                               extent_.p_object_center, T_ * extent_.p_object_center + dt * v));
}

MotionFilter::Matrix12 MotionFilter::propagated(double dt) const {
  const double steps = updates_ > 1 ? dt / step_ : 1;  // two poses tell how far apart frames are
  Matrix12 P = covariance_;
  P.topRows<6>() += steps * P.bottomRows<6>().eval();
  P.leftCols<6>() += steps * P.rightCols<6>().eval();
  const double learned = std::sqrt(2 * usual_innovation_squared_ / 6);
  const double change = updates_ < 5 ? kChange : std::clamp(learned, kLeastChange, kMostChange);
  const double q = change * change * steps;
  P.bottomRightCorner<6, 6>() += q * Matrix6::Identity();
  P.topLeftCorner<6, 6>() += 0.25 * q * steps * steps * Matrix6::Identity();
  return P;
}

MotionPrior MotionFilter::predict(double t) const {
  const double dt = going_on(t);
  return {gone_on(dt, changing_), propagated(started_ ? t - t_ : dt).topLeftCorner<6, 6>()};
}

void MotionFilter::update(const Pose& T_camera_object, const Matrix6& covariance, double t) {
  if (lost()) {
    // How it moved while it was lost says nothing of how it moves now.
    const double step = step_;
    reset(T_camera_object);
    step_ = step;
  }
  const double dt = started_ ? t - t_ : step_;
  if (started_ && updates_ == 1) step_ = dt;
  const Pose T_expected = gone_on(dt, changing_);
  const Twist innovation = displacement(T_expected, T_camera_object, extent_);
  const Matrix12 P = propagated(dt);
  const Matrix6 expected = P.topLeftCorner<6, 6>();
  const Matrix6 gain = P.bottomLeftCorner<6, 6>() * symmetric_inverse(expected);  // velocity a frame
  covariance_ = P;
  covariance_.bottomRightCorner<6, 6>() -= gain * (expected - covariance) * gain.transpose();
  covariance_.bottomLeftCorner<6, 6>() = gain * covariance;
  covariance_.topRightCorner<6, 6>() = covariance * gain.transpose();
  covariance_.topLeftCorner<6, 6>() = covariance;
  if (!started_) {  // a first pose's correction is no motion
    covariance_.setZero();
    covariance_.topLeftCorner<6, 6>() = covariance;
    covariance_.bottomRightCorner<6, 6>() = kUnknownVelocity * kUnknownVelocity * Matrix6::Identity();
  }

  if (moving()) {
    usual_innovation_squared_ +=
        kInnovationMemory *
        (std::min(innovation.squaredNorm(), 6 * kMostChange * kMostChange) - usual_innovation_squared_);
    const Twist unsteady = displacement(gone_on(dt, false), T_camera_object, extent_);
    restlessness_.add(to_camera_axes(T_camera_object) * unsteady);
    strays_[stray_count_++ % strays_.size()] = unsteady.norm();
  }
  const Twist change = gain * innovation;
  if (started_) {
    const Eigen::Matrix3d R = T_expected.linear();
    const Eigen::Vector3d velocity_before = velocity_, angular_before = angular_velocity_;
    if (changing_) {
      velocity_ += kGoesOnChanging * velocity_change_;
      angular_velocity_ += kGoesOnChanging * angular_change_;
    }
    velocity_ += R * (extent_.radius * change.head<3>()) / step_;
    angular_velocity_ += R * change.tail<3>() / step_;
    velocity_change_ = velocity_ - velocity_before;
    angular_change_ = angular_velocity_ - angular_before;
  }
  // A velocity that changes steadily goes on changing, one that has just changed suddenly does not.
  const std::size_t count = std::min(stray_count_, strays_.size());
  changing_ = false;
  if (count > 1 && moving()) {
    std::array<double, 12> sorted = strays_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
    const double stray = strays_[(stray_count_ - 1) % strays_.size()];
    changing_ = stray < std::min(kLargeChange, kSudden * *middle);
  }
  T_ = T_camera_object;
  t_ = t;
  started_ = true;
  ++updates_;
  rest();
}

void MotionFilter::miss(double t) {
  if (!started_) {
    started_ = true;
    t_ = t - step_;
  }
  ++misses_;
  restlessness_.interrupt();
}

void MotionFilter::rest() {
  const Matrix6 pose = covariance_.topLeftCorner<6, 6>();
  if (pose.trace() <= kOpen * kOpen) return;
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(pose);
  Matrix6 moving = Matrix6::Identity(), shorter = Matrix6::Identity();
  for (int i = 5; i >= 0 && solver.eigenvalues()(i) > kOpen * kOpen; --i) {
    const Matrix6 open = solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose();
    moving -= open;
    // Its variance would grow until what is known of the others drowns in its rounding.
    shorter -= (1 - std::min(1.0, kMostDeviation / std::sqrt(solver.eigenvalues()(i)))) * open;
  }
  if (moving.isIdentity(0)) return;
  covariance_.topLeftCorner<6, 6>() = shorter * pose * shorter;
  covariance_.bottomLeftCorner<6, 6>() = (moving * covariance_.bottomLeftCorner<6, 6>() * shorter).eval();
  covariance_.topRightCorner<6, 6>() = covariance_.bottomLeftCorner<6, 6>().transpose();
  covariance_.bottomRightCorner<6, 6>() = (moving * covariance_.bottomRightCorner<6, 6>() * moving).eval();
  Twist velocity;
  velocity << T_.linear().transpose() * velocity_ / extent_.radius, T_.linear().transpose() * angular_velocity_;
  velocity = (moving * velocity).eval();
  velocity_ = T_.linear() * velocity.head<3>() * extent_.radius;
  angular_velocity_ = T_.linear() * velocity.tail<3>();
}

}  // namespace holdfast
