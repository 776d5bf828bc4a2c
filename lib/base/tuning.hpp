#pragma once

#include "holdfast/options.hpp"

namespace holdfast {

/// The tracker's constants that hang on its options, in one place. Users choose a quality; experiments leave out
/// mechanisms by name (TrackerOptions::ablate).
struct Tuning : TrackerOptions {
  bool texture = true;
  bool colors = true;            ///< of both sides of the contour
  bool edges = true;             ///< of the model, beside its contour
  bool snapshot = true;          ///< a model without appearance is compared with how a frame showed it
  bool robust_weights = true;    ///< Student-t weights on what passes the tests
  bool photometric = true;       ///< gain and bias a channel, of the object and of cells, eliminated from the sums
  bool shading = true;           ///< the view is drawn as light falls on it from one side
  bool predict_velocity = true;  ///< the object goes on as it moved, beside no motion
  bool expected_motion = true;   ///< the motion prior counts beside the rows
  bool shift_search = true;      ///< on the coarsest level
  bool reliability = true;       ///< texture that passes by chance counts less

  int texture_samples = 4;       ///< of the rendered view, a pixel; 1 costs a quarter and is twice as far off
  double mesh_deviation = 0.05;  ///< pixels that a mesh of fewer triangles may be off, its texture twice
  int most_pixels = 100000;      ///< an object of more is tracked at half the resolution (quarter, ...)
  int enough_pixels = 8000;      ///< with a gradient; where more are seen, every second to fourth row is looked at
  int iterations = 5;            ///< most solved systems a level where texture is asked alone

  bool paper() const { return quality == Quality::paper; }
};

/// Throws Error(invalid_argument) for options that are out of range or ablate what there is not.
Tuning tuning_of(const TrackerOptions& options);

}  // namespace holdfast
