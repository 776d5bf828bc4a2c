#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "holdfast/pose.hpp"
#include "imaging/shading.hpp"
#include "imaging/tone_curve.hpp"

namespace holdfast {

/// Share of the usual (score, or texture seen) that an estimate must reach to be believed unchallenged.
inline constexpr double kUsualScore = 0.8;

/// One of two ways of drawing the view, as measured.
struct Choice {
  bool on = false;
  double evidence = 0;  ///< for it to be on: log of how much more is left over without, running mean
  int measured = 0;     ///< of how many measurements that is, at most eight
  int since = 0;        ///< frames that it could have been measured in, since it was
};

/// How the camera shows the texture, as measured.
struct Optics {
  using Softness = std::array<double, 5>;
  Choice light_texels{true};  ///< texels are averaged as light, not as encoded values
  Choice coarse_color;        ///< colour has half the resolution of brightness
  Choice fine_blur;           ///< the finest level is blurred less: its gradients tell more than noise takes
  double lens_variance = 0;   ///< that the lens blurs by, as it is drawn, square pixels
  Softness softness{};        ///< variances that left least over, the last ones measured
  int softness_measured = 0;  ///< how many have been
  double unsureness = 0;      ///< deviation of the pose by texture, of the one at which that is faint, running mean
  int since_lens = 0;         ///< frames that it could have been measured in, since it was
};

/// Whether what blurs the frames is motion, which blurs along itself alone: a lens blurs, and noise is averaged, in any
/// direction. By how much better views fit that are blurred along the motion, and as much across it, than sharp ones.
class Directions {
 public:
  /// Scores of the three. In fast frames they differ most, so that these count most.
  void add(double sharp, double along, double across) {
    constexpr double kMemory = 0.8;
    along_ = kMemory * along_ + gain(along, sharp);
    across_ = kMemory * across_ + gain(across, sharp);
  }
  /// What is gained along the motion is clearly more than what is gained across it.
  bool one() const { return across_ < 0.65 * along_; }

 private:
  static double gain(double score, double sharp) {
    constexpr double kLeast = 1e-3;
    return std::log(std::max(score, kLeast) / std::max(sharp, kLeast));
  }

  double along_ = 0, across_ = 0;  ///< logarithms, added up
};

/// How the object has looked lately. Every frame's estimate changes it; a frame that is not held must leave it as it
/// was.
struct Look {
  static constexpr int kMostLevels = 6;
  static constexpr double kFirstScale = 0.05;
  /// Score of the fine stage that is challenged while the usual is not known: what moves as no one knows yet, blurred
  /// by it, may converge to something else.
  static constexpr double kOrdinaryScore = 0.6;
  static constexpr int kSettled = 3;
  static constexpr int kConfirmedFrames = 5;

  std::array<double, kMostLevels> scale = first_scale();  ///< of residuals, a level each
  double usual_score = 1;                                 ///< of the coarse stage, running mean
  double usual_fine_score = 0;                            ///< of the fine stage, likewise; 0: not known yet
  double confirmed_score = 0;   ///< of the fine stage, less than usual, and that no other start led to more
  int confirmed_frames = 0;     ///< that this counts for, the one that confirms it included
  double surviving_share = 1;   ///< of the visible pixels, off the margin, on the finest level of the last frame
  double passing_share = 0.72;  ///< of the tests, where nothing is in front, in the last sums; first as it is at rest
  double exposure = 0;          ///< share of the time between frames that the shutter is open
  bool exposed_light = false;   ///< what adds up meanwhile is light, not encoded values
  int exposure_settled = 0;     ///< how often measuring it has changed nothing
  int fast_frames = 0;          ///< since it was measured
  Directions blurred;           ///< whether what blurs the frames is motion
  Shading shading;
  bool lit = true;  ///< it is drawn
  ToneCurve tone;
  Optics optics;

  /// Whether the exposure is known.
  bool exposure_known() const { return exposure_settled >= kSettled; }
  /// Of the fine stage, to live up to.
  double expected_score() const {
    const double usual = usual_fine_score > 0 ? usual_fine_score : kOrdinaryScore;
    return confirmed_frames > 0 ? std::min(usual, confirmed_score) : usual;
  }
  /// Nothing better than this score was to be had, so that the next frames need not look for it again.
  void confirm(double score) {
    confirmed_score = score;
    confirmed_frames = kConfirmedFrames;
  }

 private:
  static constexpr std::array<double, kMostLevels> first_scale() {
    std::array<double, kMostLevels> scale{};
    scale.fill(kFirstScale);
    return scale;
  }
};

/// What is known of the object from the frames that it was held in, and of the doubtful ones since.
struct Course {
  static constexpr double kUnknown = 1e9;

  double gradient_pixels = 0;          ///< on the finest level, in the last frame held
  double visible_pixels = 0;           ///< likewise, in pixels of the frame; 0: none held since the start
  double prediction_error = kUnknown;  ///< of the last frame held, pixels that it moves a corner by
  /// Square of how far it is from where its motion leads, object radii and radians, running mean.
  double usual_stray_squared = 0.0025;
  double usual_share = 0;          ///< of the gradient pixels used, when nothing is in front; 0: not known yet
  double usual_gain = 1;           ///< of the frame over the texture, running mean
  Pose T_last = Pose::Identity();  ///< the last frame's estimate, whether or not it was believed
  bool last_promising = false;     ///< likewise
  bool searching = false;          ///< over the whole picture, since it was lost
  bool faint = false;              ///< the texture seen then left the pose unsure: the outline is asked too
  bool hides = false;              ///< the rows seen then left a motion open: they showed nothing but noise of it
  double usual_hides = 0;          ///< share of the frames held by texture that did, running mean
  int held_frames = 0;             ///< that is of
  int probable_frames = 0;         ///< how often in a row, up to there, something that went on was probably the object

  /// Whether most frames leave a motion open; before the first, whether they may.
  bool hides_usually() const { return held_frames == 0 || usual_hides > 0.5; }
  /// Whether nothing has been held yet, or not since the finest level changed.
  bool fresh() const { return gradient_pixels <= 0; }
};

}  // namespace holdfast
