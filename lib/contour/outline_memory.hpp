#pragma once

#include "contour/outline_stage.hpp"

namespace holdfast {

/// What is remembered of an object's outline from frame to frame: how well it usually fits, how far it is to be
/// trusted, and when its colours are learnt anew or forgotten.
class OutlineMemory {
 public:
  void clear() { *this = {}; }

  /// Score to live up to.
  double expected_score() const;
  bool fits_as_usual(double score) const;
  /// Whether it is lower than scores scatter.
  bool unusually_low(double score) const;
  double last_score() const { return last_score_; }
  /// Of this frame; negative where it was not looked for.
  void note_score(double score) { last_score_ = score; }
  /// The last score is of a frame that was held. The first ones weigh more where they are surely the object's.
  void remember_score(bool first_are_sure = false);

  /// Beside texture its covariance turns out too small, by this factor (equation 32 of docs/math.md).
  double excess() const { return excess_; }
  /// What it says of the pose, no surer than it has turned out to be.
  Matrix6 trusted_information(const OutlineEstimate& outline) const { return outline.information / excess_; }
  /// After a frame that texture and outline have led to the same pose, of this covariance by texture alone.
  void compare(const OutlineEstimate& outline, const Pose& T_both, const Matrix6& texture_covariance);

  /// Counts a frame that needs no outline: whether its colours are of other surroundings by now.
  bool forgets();
  /// Counts a frame in which it was looked for beside texture: whether that has been in sight without it for so long
  /// that its colours must be wrong.
  bool mistrusts(bool texture_in_sight);
  /// Counts a frame that texture has held: whether its colours, if they are `known`, are learnt anew from it. Where
  /// texture is `faint`, the outline itself tells whether it is hidden.
  bool learns(bool known, bool faint, bool texture_in_sight);

 private:
  /// Of what its covariance lacks, until texture has told.
  static constexpr double kFirstExcess = 8;
  /// Of scores, until they are known.
  static constexpr double kFirstScatter = 0.05;

  double usual_score_ = 0;                                 ///< running mean; 0: not known yet
  double score_variance_ = kFirstScatter * kFirstScatter;  ///< about it, likewise
  int scores_ = 0;                                         ///< that these are of
  double last_score_ = -1;
  double excess_ = kFirstExcess;
  int since_learnt_ = 0;  ///< frames in which its colours could have been learnt
  int misses_ = 0;        ///< frames in a row without it
};

}  // namespace holdfast
