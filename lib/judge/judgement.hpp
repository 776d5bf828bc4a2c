#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "holdfast/options.hpp"
#include "holdfast/tracker.hpp"
#include "solve/proportions.hpp"
#include "solve/solver.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// Standard deviation of the orientation, radians, up to which a pose is believed where nothing else led to it: twice
/// this is less than five degrees. What is tilted the wrong way, or seen in a strip only, is less sure.
inline constexpr double kSureTurn = 0.04;

/// Standard deviation of the orientation where it is least sure, radians.
double turn_deviation(const Matrix6& conditioned_covariance);

/// A pose with what speaks for it.
struct Estimate {
  Pose T_camera_object = Pose::Identity();
  double score = -1;
  bool solved = false;
  ConstraintSums sums;
  double correlation = 0;
  /// What the rows show of a motion, conditioned (noise_information.hpp); on the finest level only.
  Matrix6 seen = Matrix6::Identity();
  bool hides = false;  ///< along some motion they show nothing but noise
  /// Of the pose, by rows and expectation, where it is largest: object radii and radians; on the finest level only.
  double deviation = std::numeric_limits<double>::infinity();
  Twist last_step = Twist::Zero();               ///< conditioned, of the last sums
  int looked_at_every = 1;                       ///< row of pixels, for the last sums
  Conditioning conditioning;                     ///< of the covariances
  Stretch stretch;                               ///< of the object beside its model; on the finest level only
  Matrix6 covariance = Matrix6::Zero();          ///< conditioned; on the finest level only
  Matrix6 texture_covariance = Matrix6::Zero();  ///< likewise, by texture and motion, without the outline

  /// Standard deviation of the orientation where it is least sure, radians; infinite where none is known. With
  /// `that_shows`, of what the rows show of it.
  double turn_deviation(bool that_shows = false) const;
  /// Of the gradient pixels, the share that decided the pose.
  double used_share() const { return sums.used / std::max(1.0, sums.gradient); }
  /// The score by its sums. Pixels that left the sampled region speak against it too.
  double merit() const { return used_share() * sums.usable / std::max(1.0, sums.visible) * std::max(0.0, correlation); }
};

/// Whether an estimate is the object, and why not, in words.
struct Verdict {
  Status status = Status::lost;
  std::string reason;
};

/// What an estimate must live up to.
struct Standing {
  bool lost_before = false;    ///< to be found again takes more than to be held on to
  bool surprising = false;     ///< held before, but not where its motion leads: takes more, too
  bool expected = false;       ///< there, or seen there by the frames before
  double usual_share = 0;      ///< of the gradient pixels used, where nothing is in front; 0: not known
  bool hides_usually = false;  ///< how it is turned never shows in full: that it does not speaks against nothing
};

/// What the words of a verdict are chosen by, too.
struct Circumstances : Standing {
  double predicted_pixels = 0;  ///< farthest that the object was expected to move since the last frame
  double blur_pixels = 0;       ///< motion blur that was found
  double gain = 1;              ///< of the frame over the model's texture, over what it was
  bool searched_everywhere = false;
  std::optional<Proportions::Misfit> misfit;  ///< of the model
};

/// Judges an estimate. A held object has a reason too where it is hard to hold.
Verdict judge(const Estimate& estimate, const TrackerOptions& options, const Circumstances& circumstances);

/// As judge(), without words.
bool is_good(const Estimate& estimate, const TrackerOptions& options, const Standing& standing);

/// Found again after a loss, if the next frame agrees.
bool is_probable(const Estimate& estimate);

/// Not to be believed, but worth starting from in the next frame.
bool is_promising(const Estimate& estimate);

}  // namespace holdfast
