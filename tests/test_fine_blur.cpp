// How much both images are blurred before they are compared: less where that makes the pose surer.
#include <doctest/doctest.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;

/// Median errors of tracked sequences, millimetres, once the blur has been measured: means over the sequences.
struct Errors {
  double with = 0;     ///< of default options
  double without = 0;  ///< of one blur for all frames
};

/// `contrast` of the print, `noise` of the frames in grey levels, `nearest` in metres.
Errors median_errors(double contrast, double noise, double nearest, std::uint64_t seed) {
  simulation::BoxOptions box;
  box.contrast = contrast;
  const Mesh mesh = simulation::textured_box(box);
  simulation::SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 60;
  options.seed = seed;
  options.motion.nearest = nearest;
  options.motion.farthest = nearest + 0.2;
  options.motion.speed = 3;
  options.sensor.noise = noise;
  const simulation::Sequence sequence(mesh, options);
  const std::vector<cv::Mat> frames = test::frames_of(sequence);
  const auto tracked = [&](double fine_blur_sigma) {
    TrackerOptions tracking;
    tracking.fine_blur_sigma = fine_blur_sigma;
    Tracker tracker(mesh, options.camera, tracking);
    return test::median_mm(tracker, sequence.poses(), frames, 20);
  };
  return {tracked(TrackerOptions{}.fine_blur_sigma), tracked(TrackerOptions{}.blur_sigma)};
}

Errors mean_errors(double contrast, double noise, double nearest) {
  constexpr int kSequences = 3;
  Errors mean;
  for (int i = 0; i < kSequences; ++i) {
    const Errors errors = median_errors(contrast, noise, nearest, 41 + static_cast<std::uint64_t>(i));
    mean.with += errors.with / kSequences;
    mean.without += errors.without / kSequences;
  }
  return mean;
}

}  // namespace

// With as little blur in all frames the noisy ones are not held at all.
TEST_CASE("a faint print is tracked more accurately with less blur, a noisy one with as much as ever") {
  const Errors faint = mean_errors(0.2, 0.5, 1.6), noisy = mean_errors(0.5, 20, 1.0);
  INFO("mean of median errors, mm: faint print ", faint.with, " with, ", faint.without, " without; noisy frames ",
       noisy.with, " with, ", noisy.without, " without");
  CHECK(faint.with < 0.8 * faint.without);
  CHECK(noisy.with < 1.1 * noisy.without);
}
