#include "holdfast/options.hpp"

#include <cmath>
#include <map>
#include <string>

#include "base/tuning.hpp"
#include "holdfast/error.hpp"

namespace holdfast {
namespace {

void check(bool good, const char* field, const char* range) {
  if (!good) throw Error(ErrorCode::invalid_argument, std::string("option ") + field + " must be " + range);
}

bool at_least(double value, double least) { return value >= least && std::isfinite(value); }

/// Mechanisms that can be left out.
const std::map<std::string, bool Tuning::*>& mechanisms() {
  static const std::map<std::string, bool Tuning::*> names{{"texture", &Tuning::texture},
                                                           {"robust_weights", &Tuning::robust_weights},
                                                           {"velocity", &Tuning::predict_velocity},
                                                           {"expected_motion", &Tuning::expected_motion},
                                                           {"shift_search", &Tuning::shift_search},
                                                           {"shading", &Tuning::shading},
                                                           {"reliability", &Tuning::reliability},
                                                           {"colors", &Tuning::colors},
                                                           {"edges", &Tuning::edges},
                                                           {"snapshot", &Tuning::snapshot}};
  return names;
}

}  // namespace

TrackerOptions TrackerOptions::paper() {
  TrackerOptions options;
  options.quality = Quality::paper;
  options.levels = 1;
  options.contour = false;
  options.motion_blur = false;
  options.recovery = false;
  OcclusionOptions& tests = options.occlusion;
  tests.magnitude_test = true;
  tests.angle_together = false;
  tests.difference_relative = 0;
  tests.vote_share = 0.35;  // of what passes these thresholds, where the vote is asked for
  tests.redundancy = true;
  return options;
}

TrackerOptions TrackerOptions::fast() {
  TrackerOptions options;
  options.quality = Quality::fast;
  return options;
}

void TrackerOptions::validate() const {
  check(quality == Quality::accurate || quality == Quality::fast || quality == Quality::paper, "quality",
        "one of Quality");
  check(occlusion.gradient_minimum >= 0 && std::isfinite(occlusion.gradient_minimum), "gradient_minimum", "0 or more");
  check(occlusion.angle_maximum > 0 && occlusion.angle_maximum <= 1.5708, "angle_maximum", "in (0, pi/2] radians");
  check(at_least(occlusion.difference_maximum, 0), "difference_maximum", "0 or more");
  check(at_least(occlusion.difference_relative, 0), "difference_relative", "0 or more");
  check(occlusion.vote_share >= 0 && occlusion.vote_share <= 1, "vote_share", "in [0, 1]");
  check(occlusion.redundancy_cosine > 0 && occlusion.redundancy_cosine <= 1, "redundancy_cosine", "in (0, 1]");
  check(levels >= 1 && levels <= 6, "levels", "in [1, 6]");
  check(search_radius >= 0 && search_radius <= 512, "search_radius", "in [0, 512] pixels");
  check(at_least(recovery_budget_ms, 0), "recovery_budget_ms", "0 or more");
  for (const std::string& name : ablate) {
    if (mechanisms().count(name) > 0) continue;
    std::string known;
    for (const auto& [mechanism, member] : mechanisms()) known += (known.empty() ? "" : ", ") + mechanism;
    throw Error(ErrorCode::invalid_argument, "option ablate: there is no mechanism '" + name + "'; known are " + known);
  }
}

Tuning tuning_of(const TrackerOptions& options) {
  options.validate();
  Tuning tuning{options};
  tuning.photometric = tuning.shading = options.light_compensation;
  if (options.quality == Quality::fast) {
    tuning.texture_samples = 1;
    tuning.mesh_deviation = 0.1;
    tuning.most_pixels = 16000;
    tuning.enough_pixels = 2000;
  }
  if (options.quality == Quality::paper) {
    tuning.texture_samples = 1;
    tuning.iterations = 1;
    tuning.shading = tuning.shift_search = tuning.reliability = false;
  }
  for (const std::string& name : options.ablate) tuning.*mechanisms().at(name) = false;
  return tuning;
}

}  // namespace holdfast
