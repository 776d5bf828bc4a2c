#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "simulation/sequence.hpp"
#include "trackability/trial.hpp"

namespace holdfast::trackability {

/// What was tried, beside the sequence asked for.
struct Findings {
  TrialResult asked;
  double speed = 0;                                    ///< pixels a frame that 95 % of the frames keep to
  double metres_a_pixel = 0;                           ///< across the optical axis at the middle distance; 0: not known
  double nearest = 0;                                  ///< of the object, metres
  double farthest = 0;                                 ///< metres
  bool occluded = false;                               ///< the sequence asked for has occluders
  std::vector<std::pair<double, TrialResult>> faster;  ///< by rising speed, pixels a frame
  std::vector<std::pair<double, TrialResult>> farther;  ///< by rising distance (the nearest), metres
  std::optional<TrialResult> behind_bar;
};

enum class Verdict { yes, partly, no };

/// yes: good in 99 % of the frames; partly: in 80 %.
Verdict verdict(const TrialResult& trial);

/// The answer in words and numbers, a few lines.
std::string report_text(const Findings& findings);

/// Tries faster motion than asked for (twice the speed and again, until it is lost), the same farther away, and a white
/// bar in front.
/// `asked` is the sequence's own result; `announce` is told what is tried next.
Findings investigate(const simulation::SequenceOptions& options, const Mesh& mesh, const TrialResult& asked,
                     const Device& device, int threads, const std::function<void(const std::string&)>& announce);

}  // namespace holdfast::trackability
