#pragma once

#include "holdfast/export.hpp"

namespace holdfast {

/// The tests of one pixel's gradients (paper, equations 5 to 7; docs/math.md, equations 7 to 10).
struct OcclusionOptions {
  bool gradient_test = true;           ///< test (5)
  bool angle_test = true;              ///< test (6)
  bool magnitude_test = true;          ///< test (7)
  bool block_vote = true;              ///< most gradient pixels of the 9x9 neighbourhood must have passed
  bool all_channels = false;           ///< test (5) asks all channels for a gradient, not any
  bool angle_together = true;          ///< test (6) turns the strong channels' gradients as one vector, not each
  bool compare_magnitudes = false;     ///< test (7) compares lengths, not vectors
  double gradient_minimum = 0.00992;   ///< t_gm as a magnitude: intensity in [0, 1] a pixel; paper: sqrt(98.4e-6)
  double angle_maximum = 0.4503;       ///< t_theta, radians; paper: 25.8 degrees
  double difference_maximum = 0.0392;  ///< t_md, intensity a pixel; paper: 39.2e-3
  double difference_relative = 0.7;    ///< added to t_md, as a share of the larger gradient; paper: 0
  double vote_share = 0.7;             ///< of the neighbourhood's gradient pixels
  bool vote_relative = false;          ///< the share is one of what passes where nothing is in front
};

/// Which tracker the options describe. Of itself it sets none of them: take TrackerOptions(), fast(), paper() or
/// published() and change from there.
enum class Mode {
  standard,  ///< "default": iterated, robust, coarse to fine, photometric compensation
  fast,      ///< as standard, with options that cost accuracy and save time
  paper,     ///< one render, one solve, as de Ruiter and Benhabib (2008)
};

struct HOLDFAST_EXPORT TrackerOptions {
  Mode mode = Mode::standard;
  OcclusionOptions occlusion;
  bool redundancy = false;         ///< a channel whose gradient repeats another's direction is added to its row
  double redundancy_cosine = 0.9;  ///< |cos| above which a channel repeats another
  double blur_sigma = 1.0;         ///< Gaussian of both images, pixels of the level
  double fine_blur_sigma = 0.65;   ///< on the finest level, where frames show that the pose is surer with it
  int silhouette_margin = 2;       ///< most pixels dropped at silhouette and depth jumps; thin objects lose one
  double depth_jump = 0.02;        ///< relative depth step that counts as a jump
  int levels = 4;                  ///< most pyramid levels; small objects use fewer
  int finest_level = 0;            ///< 0: full resolution; 1: half
  int texture_samples = 4;         ///< of the rendered view, a pixel: 1, or 4 averaged as light
  double mesh_deviation =
      0.05;                  ///< pixels that a mesh of fewer triangles may be off, texture twice; 0: none are left out
  int most_pixels = 100000;  ///< an object of more is tracked at half the resolution (quarter, ...)
  int enough_pixels = 8000;  ///< with a gradient; where more are seen, every second to fourth row is looked at
  int iterations = 5;        ///< most solved systems a level
  bool robust_weights = true;      ///< Student-t weights on what passes the tests
  bool photometric = true;         ///< gain and bias a channel, global and a tile
  bool shading = true;             ///< draw the view as light falls on it from one side, as learnt from the frames
  bool tone_curve = true;          ///< and as the camera encodes what the texture's encoded otherwise, if it does
  bool light_texels = true;        ///< average texels as light where the frames show that; false: as encoded values
  bool coarse_color = true;        ///< draw colour as coarse as codecs keep it, where the frames show that
  bool lens_blur = true;           ///< draw the view as blurred as the lens makes it; how much is measured
  bool mean_gradient = true;       ///< rows from the mean of rendered and frame gradients; false: rendered only
  bool predict_velocity = true;    ///< the object may go on as it moved, beside no motion
  bool expected_motion = true;     ///< where its motion leads counts beside the rows, as surely as poses are known
  bool correlation_search = true;  ///< shift search on the coarsest level
  bool motion_blur = true;  ///< draw the view as blurred as the shutter makes it; how long it is open is measured
  bool challenge = true;    ///< a result worse than usual is challenged by starts turned away from it
  bool recovery = true;     ///< a lost object is searched for over the whole picture; such a frame takes longer
  /// Follow the outline too where texture says little, and alone where there is none; false: models without any are an
  /// error.
  bool outline = true;
  double faint_deviation = 0.02;    ///< of the pose, object radii and radians, that is little said: standard deviation
  int search_radius = 32;           ///< of the shift search, pixels of the full frame
  double lost_correlation = 0.5;    ///< below: lost
  double lost_visible_share = 0.1;  ///< of the usable gradient pixels that must be used, else lost

  /// One view and one solution a frame, with the paper's tests and thresholds, steadied by the block vote, gain and
  /// bias, robust weights, a narrower blur, texels averaged as light, and what its motion lets expect
  /// (docs/experiments.md).
  static TrackerOptions paper();

  /// The same without what steadies it: the paper's tracker as published (de Ruiter and Benhabib, 2008).
  static TrackerOptions published();

  /// Default mode for a tenth to half of its time (docs/performance.md), one to eight times its median error (README).
  static TrackerOptions fast();

  /// Throws Error(invalid_argument) naming the field that is out of range.
  void validate() const;
};

}  // namespace holdfast
