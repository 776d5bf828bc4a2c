#include "holdfast/options.hpp"

#include <cmath>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast {
namespace {

void check(bool good, const char* field, const char* range) {
  if (!good) throw Error(ErrorCode::invalid_argument, std::string("option ") + field + " must be " + range);
}

bool at_least(double value, double least) { return value >= least && std::isfinite(value); }

}  // namespace

TrackerOptions TrackerOptions::paper() {
  TrackerOptions options = published();
  options.occlusion.block_vote = true;
  options.blur_sigma = options.fine_blur_sigma = 0.8;
  options.robust_weights = true;
  options.photometric = true;
  options.light_texels = true;
  options.expected_motion = true;
  options.lost_visible_share = 0.05;  // fewer pass these thresholds
  return options;
}

TrackerOptions TrackerOptions::published() {
  TrackerOptions options;
  options.mode = Mode::paper;
  options.occlusion.block_vote = false;
  options.occlusion.angle_together = false;
  options.occlusion.difference_relative = 0;
  options.occlusion.vote_share = 0.5;
  options.occlusion.vote_relative = true;
  options.redundancy = true;
  options.robust_weights = false;
  options.photometric = false;
  options.shading = false;
  options.tone_curve = false;
  options.light_texels = false;
  options.coarse_color = false;
  options.fine_blur_sigma = options.blur_sigma;
  options.lens_blur = false;
  options.mean_gradient = false;
  options.expected_motion = false;
  options.correlation_search = false;
  options.motion_blur = false;
  options.outline = false;
  options.challenge = false;
  options.recovery = false;
  options.texture_samples = 1;
  options.levels = 1;
  options.iterations = 1;
  return options;
}

TrackerOptions TrackerOptions::fast() {
  TrackerOptions options;
  options.mode = Mode::fast;
  options.lens_blur = false;  // seen at half the resolution it matters little
  options.texture_samples = 1;
  options.mesh_deviation = 0.1;
  options.most_pixels = 16000;
  options.enough_pixels = 2000;
  options.faint_deviation = 0.04;
  return options;
}

void TrackerOptions::validate() const {
  check(mode == Mode::standard || mode == Mode::fast || mode == Mode::paper, "mode", "one of Mode");
  check(at_least(occlusion.gradient_minimum, 0), "gradient_minimum", "0 or more");
  check(occlusion.angle_maximum > 0 && occlusion.angle_maximum <= 1.5708, "angle_maximum", "in (0, pi/2] radians");
  check(at_least(occlusion.difference_maximum, 0), "difference_maximum", "0 or more");
  check(at_least(occlusion.difference_relative, 0), "difference_relative", "0 or more");
  check(occlusion.vote_share >= 0 && occlusion.vote_share <= 1, "vote_share", "in [0, 1]");
  check(redundancy_cosine > 0 && redundancy_cosine <= 1, "redundancy_cosine", "in (0, 1]");
  check(blur_sigma >= 0 && blur_sigma <= 2.6, "blur_sigma", "in [0, 2.6] pixels");
  check(fine_blur_sigma >= 0 && fine_blur_sigma <= 2.6, "fine_blur_sigma", "in [0, 2.6] pixels");
  check(silhouette_margin >= 0 && silhouette_margin <= 8, "silhouette_margin", "in [0, 8] pixels");
  check(depth_jump > 0, "depth_jump", "positive");
  check(levels >= 1 && levels <= 6, "levels", "in [1, 6]");
  check(finest_level >= 0 && finest_level < levels, "finest_level", "at least 0 and less than the number of levels");
  check(texture_samples == 1 || texture_samples == 4, "texture_samples", "1 or 4");
  check(mesh_deviation >= 0 && mesh_deviation <= 10, "mesh_deviation", "in [0, 10] pixels");
  check(most_pixels >= 1000, "most_pixels", "1000 or more");
  check(enough_pixels >= 100, "enough_pixels", "100 or more");
  check(iterations >= 1 && iterations <= 100, "iterations", "in [1, 100]");
  check(faint_deviation > 0, "faint_deviation", "positive");
  check(search_radius >= 0 && search_radius <= 512, "search_radius", "in [0, 512] pixels");
  check(lost_correlation >= -1 && lost_correlation <= 1, "lost_correlation", "in [-1, 1]");
  check(lost_visible_share >= 0 && lost_visible_share <= 1, "lost_visible_share", "in [0, 1]");
}

}  // namespace holdfast
