#include "trackability/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "holdfast/error.hpp"
#include "simulation/motion.hpp"

namespace holdfast::trackability {
namespace {

using simulation::Sequence;
using simulation::SequenceOptions;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMillimetres = 1e3;
constexpr double kYesShare = 0.99;
constexpr double kPartlyShare = 0.8;
// Enough for one to tell whether a speed is followed; the motion asked for is tried in full.
constexpr int kFramesOfFurtherTrials = 80;
constexpr int kDoublings = 3;
constexpr double kBarShareOfObject = 0.3;
// Below these the object is hard to hold whatever moves: docs/results/experiments.md shows how accuracy falls.
constexpr double kFewPixels = 1200;
constexpr double kLittleTexture = 0.15;

std::string per_cent(double share) { return fmt::format("{:.0f} %", std::floor(100 * share)); }

std::string speed_text(const Findings& findings, double speed) {
  if (findings.metres_a_pixel <= 0) {
    return fmt::format("{:.3g} pixels a frame", speed);
  }
  return fmt::format("{:.3g} pixels a frame ({:.2g} m/s at 30 frames a second)", speed,
                     30 * speed * findings.metres_a_pixel);
}

std::string outcome(const TrialResult& trial) {
  switch (verdict(trial)) {
    case Verdict::yes:
      return "held";
    case Verdict::partly:
      return "held in " + per_cent(trial.good_share());
    case Verdict::no:
      break;
  }
  return "lost (held in " + per_cent(trial.good_share()) + ")";
}

std::string headline(const TrialResult& trial) {
  const char* word = "NO";
  if (verdict(trial) != Verdict::no) {
    word = verdict(trial) == Verdict::yes ? "YES" : "PARTLY";
  }
  std::string text = fmt::format("Can it be tracked? {}: followed in {} of {} frames", word, trial.good, trial.frames);
  if (trial.lost > 0) {
    text += fmt::format(", reported lost in {}", trial.lost);
  }
  if (trial.wrong > 0) {
    text += fmt::format(", held in a wrong pose in {}", trial.wrong);
  }
  return text + ".\n";
}

std::vector<std::string> advice(const Findings& findings) {
  std::vector<std::string> out;
  const TrialResult& asked = findings.asked;
  if (asked.median_pixels < kFewPixels) {
    out.emplace_back("it is small in the picture: bring it nearer, or use a longer lens or more pixels");
  }
  if (asked.textured_share < kLittleTexture) {
    out.emplace_back("little of its surface has texture: print or stick some on, or light it so that it shows");
  }
  if (verdict(asked) == Verdict::yes || !out.empty()) {
    return out;
  }
  if (findings.occluded) {
    out.emplace_back("something hides it: see whether it holds without (leave out --occluder)");
  } else {
    out.emplace_back("it moves fast: ask again with a lower --speed, film with more frames a second");
  }
  return out;
}

/// Nothing where no such motion fits into the picture.
std::optional<TrialResult> try_with(const SequenceOptions& options, const Mesh& mesh, const Device& device,
                                    int threads) {
  try {
    return run_trial(Sequence(mesh, options), mesh, device, threads);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid_argument) {
      throw;
    }
    return std::nullopt;
  }
}

std::string compared_by(const TrialResult& trial) {
  if (trial.by_contour == trial.frames) return "followed by its contour, for want of texture";
  std::string text = per_cent(trial.textured_share) + " of them with texture to compare";
  if (trial.by_contour > 0) {
    text += fmt::format("; {} of {} frames show none: followed by the contour", trial.by_contour, trial.frames);
  }
  return text;
}

}  // namespace

Verdict verdict(const TrialResult& trial) {
  if (trial.good_share() >= kYesShare) {
    return Verdict::yes;
  }
  return trial.good_share() >= kPartlyShare ? Verdict::partly : Verdict::no;
}

std::string report_text(const Findings& findings) {
  const TrialResult& asked = findings.asked;
  std::string text = headline(asked);
  const auto line = [&text](const char* what, const std::string& words) {
    text += fmt::format("  {:<12}{}\n", what, words);
  };
  line("size", fmt::format("{:.0f} pixels of the picture (median), {:.0f} at least; {}", asked.median_pixels,
                           asked.least_pixels, compared_by(asked)));
  line("distance", fmt::format("{:.3g} to {:.3g} m", findings.nearest, findings.farthest));
  for (const auto& [distance, trial] : findings.farther) {
    line("  farther", fmt::format("{:.3g} m, {:.0f} pixels: {}", distance, trial.median_pixels, outcome(trial)));
  }
  if (asked.good > 0) {
    line("accuracy",
         fmt::format("{:.2g} mm and {:.2g} degrees (median), {:.2g} mm and {:.2g} degrees (worst; {:.2g} mm of it in "
                     "depth)",
                     kMillimetres * asked.median_distance, kDegrees * asked.median_rotation,
                     kMillimetres * asked.worst_distance, kDegrees * asked.worst_rotation,
                     kMillimetres * asked.worst_depth));
  }
  if (findings.speed > 0) {
    line("speed", fmt::format("{}: {}", speed_text(findings, findings.speed), outcome(asked)));
  }
  for (const auto& [speed, trial] : findings.faster) {
    line("  faster", fmt::format("{}: {}", speed_text(findings, speed), outcome(trial)));
  }
  if (findings.behind_bar) {
    line("hidden", fmt::format("while a white bar sweeps across: {}", outcome(*findings.behind_bar)));
  }
  line("time", fmt::format("{:.1f} ms a frame on this machine", asked.median_ms));
  for (const std::string& words : advice(findings)) {
    line("advice", words);
  }
  return text;
}

Findings investigate(const SequenceOptions& options, const Mesh& mesh, const TrialResult& asked, const Device& device,
                     int threads, const std::function<void(const std::string&)>& announce) {
  Findings out;
  out.asked = asked;
  out.occluded = !options.occluders.empty();
  const Sequence sequence(mesh, options);
  const simulation::MotionSummary motion = simulation::summarize_motion(sequence.poses(), mesh, options.camera);
  out.speed = motion.speed_95;
  out.nearest = motion.nearest;
  out.farthest = motion.farthest;
  out.metres_a_pixel = 0.5 * (motion.nearest + motion.farthest) / options.camera.fx;

  SequenceOptions further = options;
  further.frames = std::min(options.frames, kFramesOfFurtherTrials);
  const bool made_motion =
      options.motion.T_camera_object.empty() && options.motion.style != simulation::MotionStyle::still;
  // Doubles something until the object is lost; `double_it` returns what it is now.
  const auto series = [&](const std::function<double(SequenceOptions&)>& double_it, const char* what) {
    std::vector<std::pair<double, TrialResult>> found;
    SequenceOptions changed = further;
    for (int i = 0; made_motion && verdict(asked) == Verdict::yes && i < kDoublings; ++i) {
      const double value = double_it(changed);
      announce(fmt::format("trying {:.3g} {}", value, what));
      const std::optional<TrialResult> trial = try_with(changed, mesh, device, threads);
      if (trial) {
        found.emplace_back(value, *trial);
      }
      if (!trial || verdict(*trial) == Verdict::no) {
        break;
      }
    }
    return found;
  };
  out.faster = series([](SequenceOptions& o) { return o.motion.speed *= 2; }, "pixels a frame");
  further.motion.nearest = out.nearest;
  further.motion.farthest = out.farthest;
  out.farther = series(
      [](SequenceOptions& o) {
        o.motion.farthest *= 2;
        return o.motion.nearest *= 2;
      },
      "metres");
  further.motion = options.motion;
  if (!out.occluded && verdict(asked) != Verdict::no) {
    announce("trying it behind a white bar");
    further.occluders.emplace_back();
    further.occluders.back().sweeps = 1;
    further.occluders.back().bar_width = std::max(2.0, kBarShareOfObject * std::sqrt(asked.median_pixels));
    out.behind_bar = run_trial(Sequence(mesh, further), mesh, device, threads);
  }
  return out;
}

}  // namespace holdfast::trackability
