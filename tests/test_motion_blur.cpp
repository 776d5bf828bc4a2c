// The tracker on sequences whose frames are blurred by a shutter that stays open while the object moves.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;

simulation::SequenceOptions shutter(double open) {
  simulation::SequenceOptions options = test::noisy_box(40, 11, 0.7, 1.0);
  options.motion.speed = 16;
  options.motion_blur = open;
  return options;
}

struct Run {
  double median_mm = 0;
  int held = 0;
};

Run run(const Mesh& mesh, const simulation::Sequence& sequence, bool motion_blur) {
  TrackerOptions options;
  options.motion_blur = motion_blur;
  Tracker tracker(mesh, sequence.camera(), options);
  tracker.reset(sequence.pose(0));
  std::vector<double> errors;
  Run out;
  for (int i = 1; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const FrameResult result = tracker.track(test::view_of(frame));
    out.held += result.status == Status::held;
    errors.push_back(1e3 * (sequence.pose(i).translation() - result.T_camera_object.translation()).norm());
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  out.median_mm = errors[errors.size() / 2];
  return out;
}

}  // namespace

TEST_CASE("a shutter that is open for 0.6 of the time loses no frame, and its blur is measured: errors halve") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0.6));
  const Run with = run(mesh, sequence, true), without = run(mesh, sequence, false);
  INFO("median error with ", with.median_mm, " mm, without ", without.median_mm, " mm");
  CHECK(with.held == sequence.size() - 1);
  CHECK(with.median_mm < 0.5 * without.median_mm);
  CHECK(with.median_mm < 0.4);
}

TEST_CASE("sharp frames of fast motion stay as accurate with the search for blur as without") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0));
  const Run with = run(mesh, sequence, true), without = run(mesh, sequence, false);
  INFO("median error with ", with.median_mm, " mm, without ", without.median_mm, " mm");
  CHECK(with.held == sequence.size() - 1);
  CHECK(with.median_mm < 1.2 * without.median_mm);
}

TEST_CASE("reset() forgets the shutter too: a second run of the same tracker gives the same bits") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0.6));
  Tracker tracker(mesh, sequence.camera(), {});
  std::vector<Pose> first;
  for (int run = 0; run < 2; ++run) {
    tracker.reset(sequence.pose(0));
    for (int i = 1; i < std::min(sequence.size(), 16); ++i) {
      const cv::Mat frame = sequence.frame(i);
      const Pose T = tracker.track(test::view_of(frame)).T_camera_object;
      if (run == 0) {
        first.push_back(T);
      } else {
        CHECK(T.matrix() == first[static_cast<std::size_t>(i - 1)].matrix());
      }
    }
  }
}
