#pragma once

#include <span>
#include <vector>

#include "evaluation/protocol.hpp"
#include "holdfast/device.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"

/// "Will my object be trackable with my camera at this distance?", answered by tracking simulated frames.
namespace holdfast::trackability {

/// What tracking one simulated sequence gave.
struct TrialResult {
  int frames = 0;
  int good = 0;   ///< held, and within a twentieth of the object's diameter and 5 degrees of the truth
  int lost = 0;   ///< reported lost
  int wrong = 0;  ///< reported held, yet not good
  double median_distance = 0, worst_distance = 0;  ///< metres, of the good frames
  double worst_depth = 0;                          ///< metres, of the good frames
  double median_rotation = 0, worst_rotation = 0;  ///< radians, of the good frames
  double median_pixels = 0, least_pixels = 0;      ///< of the picture, that show the object
  int by_contour = 0;                              ///< frames followed by the contour alone, for want of texture
  double textured_share = 0;                       ///< of the object's pixels that have a gradient to compare, median
  double median_ms = 0;                            ///< tracking, a frame

  double good_share() const { return frames > 0 ? static_cast<double>(good) / frames : 0; }
};

/// Sums up the frames of a sequence: records, the object's visible pixels in each, its diameter in metres.
TrialResult summarize_trial(std::span<const evaluation::FrameRecord> records, std::span<const double> pixels,
                            double diameter);

/// A tracker that follows a sequence as it is made, from the true first pose on, and is never reset.
class Trial {
 public:
  /// Throws as Tracker's constructor does.
  Trial(const Mesh& mesh, const Camera& camera, const Device& device);

  /// The next frame, in order. Throws Error(pose) where the first pose cannot be started from.
  void add(const simulation::SimulatedFrame& frame);

  TrialResult result() const;

 private:
  Tracker tracker_;
  double diameter_;
  std::vector<evaluation::FrameRecord> records_;
  std::vector<double> pixels_;  // of each frame that show the object
};

/// Follows all frames of a sequence without keeping them. `threads` draw at a time; 0: one a core.
TrialResult run_trial(const simulation::Sequence& sequence, const Mesh& mesh, const Device& device, int threads = 0);

}  // namespace holdfast::trackability
