#include "contour/outline_memory.hpp"

#include <algorithm>
#include <cmath>

#include "solve/covariance.hpp"
#include "tracker/tracker_state.hpp"

namespace holdfast {
namespace {

/// Score taken for usual until it is known, and the weight of a new frame in it.
constexpr double kOrdinaryScore = 0.85, kScoreMemory = 0.1;
/// Standard deviations, and score, that an unusually low one lacks.
constexpr double kLow = 2, kLeastLow = 0.05;
/// How fast what the covariance lacks follows what each frame says of it, how much that is at most, and between which
/// factors it stays.
constexpr double kExcessMemory = 0.1, kMostSquare = 4, kLeastExcess = 1, kMostExcess = 30;
/// Of the frames in which texture is sure enough without it, one in so many is learnt from.
constexpr int kLearnEvery = 4;
/// Frames after which colours are of other surroundings.
constexpr int kForgottenAfter = 30;
/// Frames in a row in which texture is seen as usual and the outline is not, after which its colours are learnt anew.
constexpr int kMostMisses = 3;

}  // namespace

double OutlineMemory::expected_score() const { return usual_score_ > 0 ? usual_score_ : kOrdinaryScore; }

bool OutlineMemory::fits_as_usual(double score) const { return score > kUsualScore * expected_score(); }

bool OutlineMemory::unusually_low(double score) const {
  return score < expected_score() - std::max(kLeastLow, kLow * std::sqrt(score_variance_));
}

void OutlineMemory::remember_score(bool first_are_sure) {
  if (last_score_ < 0) return;
  const double off = last_score_ - expected_score();
  // Something in front of it must not become usual.
  const double square = std::min(off * off, kLow * kLow * score_variance_);
  score_variance_ += kScoreMemory * (square - score_variance_);
  ++scores_;
  const double weight = first_are_sure ? 1.0 / (1 + scores_) : 0;
  usual_score_ = expected_score() + std::max(kScoreMemory, weight) * off;
}

void OutlineMemory::compare(const OutlineEstimate& outline, const Pose& T_both, const Matrix6& texture_covariance) {
  const Matrix6 information = trusted_information(outline);
  const Twist pull =
      information * outline.conditioning.conditioned(log_se3(outline.T_camera_object * T_both.inverse()));
  const double square = pull.dot((texture_covariance + symmetric_inverse(information)) * pull) / 6;
  const double factor = std::pow(std::clamp(square, 1 / kMostSquare, kMostSquare), kExcessMemory);
  excess_ = std::clamp(excess_ * factor, kLeastExcess, kMostExcess);
}

bool OutlineMemory::forgets() { return ++since_learnt_ > kForgottenAfter; }

bool OutlineMemory::mistrusts(bool texture_in_sight) {
  misses_ = fits_as_usual(last_score_) || !texture_in_sight ? 0 : misses_ + 1;
  return misses_ >= kMostMisses;
}

bool OutlineMemory::learns(bool known, bool faint, bool texture_in_sight) {
  if (!known) usual_score_ = scores_ = 0;
  // What an occluder looks like is not to be learnt as the object's.
  const bool hidden = known && faint ? !fits_as_usual(last_score_) : !texture_in_sight;
  if (hidden || (known && !faint && ++since_learnt_ < kLearnEvery)) return false;
  since_learnt_ = misses_ = 0;
  return true;
}

}  // namespace holdfast
