#pragma once

#include <string>
#include <vector>

#include "holdfast/export.hpp"

namespace holdfast {

/// Which tracker is run.
enum class Quality {
  accurate,  ///< iterated, robust, coarse to fine, texture and contour together
  fast,      ///< the same with half the resolution for large objects and fewer pixels
  paper,     ///< one view and one solution a frame from texture alone: de Ruiter and Benhabib (2008)
};

/// The paper's tests of one pixel's gradients (its equations 5 to 7; docs/math.md, equations 7 to 10), and what it
/// makes of colour channels that repeat each other. Defaults are those of Quality::accurate; TrackerOptions::paper()
/// has the paper's.
struct OcclusionOptions {
  bool gradient_test = true;           ///< test (5): a gradient in both images
  bool angle_test = true;              ///< test (6): gradients point the same way
  bool magnitude_test = false;         ///< test (7): gradients differ little
  bool block_vote = false;             ///< most gradient pixels of the 9x9 neighbourhood must have passed
  bool angle_together = true;          ///< test (6) turns the strong channels' gradients as one vector, not each
  double gradient_minimum = 0.00992;   ///< t_gm as a magnitude: intensity in [0, 1] a pixel; paper: sqrt(98.4e-6)
  double angle_maximum = 0.4503;       ///< t_theta, radians; paper: 25.8 degrees
  double difference_maximum = 0.0392;  ///< t_md, intensity a pixel; paper: 39.2e-3
  double difference_relative = 0.7;    ///< added to t_md, as a share of the larger gradient; paper: 0
  double vote_share = 0.7;             ///< of the neighbourhood's gradient pixels
  bool redundancy = false;             ///< a channel whose gradient repeats another's direction has no row of its own
  double redundancy_cosine = 0.9;      ///< |cos| above which a channel repeats another
};

struct HOLDFAST_EXPORT TrackerOptions {
  Quality quality = Quality::accurate;
  int levels = 4;                  ///< most pyramid levels, 1 to 6; small objects use fewer
  int search_radius = 32;          ///< of the search for the shift since the last frame, pixels of the frame
  bool contour = true;             ///< the contour is followed too; false: a model without texture is an error
  bool light_compensation = true;  ///< gain and bias of the camera, light from one side
  bool motion_blur = true;         ///< the view is drawn as blurred as the shutter makes it
  bool recovery = true;            ///< a lost object is searched for over the whole picture
  double recovery_budget_ms = 25;  ///< nominal time of that search in one frame, on one core; it goes on in the next
  OcclusionOptions occlusion;
  /// Names of mechanisms to leave out, for experiments: texture, robust_weights, velocity, expected_motion,
  /// shift_search, shading, reliability, colors (of the contour), edges, snapshot.
  std::vector<std::string> ablate;

  /// One view and one solution a frame, with the paper's tests and thresholds, steadied by gain and
  /// bias and the motion's prediction (docs/results/experiments.md).
  static TrackerOptions paper();
  /// Accurate mode at half the resolution for large objects (docs/results/performance.md).
  static TrackerOptions fast();

  /// Throws Error(invalid_argument) naming the field that is out of range.
  void validate() const;
};

}  // namespace holdfast
