// What tracking gains where a codec has kept colour at half the resolution of brightness, and what it loses elsewhere.
#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;

/// A flat print, 0.2 m wide, whose colours have little to do with its brightness.
Mesh colorful_print(int texels) { return test::quad(test::random_texture(texels, texels, 21)); }

simulation::SequenceOptions moderate_motion() {
  simulation::SequenceOptions options;
  options.camera = {320, 240, 375, 375, 159.5, 119.5, {}};
  options.frames = 40;
  options.seed = 108;
  options.motion.nearest = 0.55;
  options.motion.farthest = 0.7;
  options.motion.speed = 3;
  options.sensor.noise = 1;
  return options;
}

/// As JPEG at 95 % keeps them: hardly a trace but for the colour's resolution.
std::vector<cv::Mat> compressed(const std::vector<cv::Mat>& frames) {
  std::vector<cv::Mat> result;
  for (const cv::Mat& frame : frames) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", frame, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
    result.push_back(cv::imdecode(bytes, cv::IMREAD_COLOR));
  }
  return result;
}

Tracker tracker_of(const simulation::Sequence& sequence, const Mesh& mesh, bool coarse_color) {
  TrackerOptions options;
  options.coarse_color = coarse_color;
  return Tracker(mesh, sequence.options().camera, options);
}

}  // namespace

TEST_CASE("compressed frames are tracked more accurately with coarse colour") {
  const Mesh mesh = colorful_print(80);
  const simulation::Sequence sequence(mesh, moderate_motion());
  const std::vector<cv::Mat> frames = compressed(test::frames_of(sequence));
  const auto median_mm = [&](bool coarse_color) {
    Tracker tracker = tracker_of(sequence, mesh, coarse_color);
    return test::median_mm(tracker, sequence.poses(), frames, 6);  // it is measured in the first ones
  };
  const double with = median_mm(true), without = median_mm(false);
  INFO("median errors, mm: ", with, " with, ", without, " without");
  CHECK(with < 0.7 * without);
}

TEST_CASE("a print as fine as the codec's colour is held from the first frame on") {
  const Mesh mesh = colorful_print(120);  // a texel a pixel
  const simulation::Sequence sequence(mesh, moderate_motion());
  const std::vector<cv::Mat> frames = compressed(test::frames_of(sequence));
  const auto held = [&](bool coarse_color) {
    Tracker tracker = tracker_of(sequence, mesh, coarse_color);
    tracker.reset(sequence.poses().front());
    return std::count_if(frames.begin(), frames.end(), [&](const cv::Mat& frame) {
      return tracker.track(test::view_of(frame)).status == Status::held;
    });
  };
  CHECK(held(true) == sequence.size());
  CHECK(held(false) < sequence.size() / 2);
}

TEST_CASE("frames as a sensor delivers them are tracked as without, to the bit") {
  const Mesh mesh = colorful_print(80);
  const simulation::Sequence sequence(mesh, moderate_motion());
  const std::vector<cv::Mat> frames = test::frames_of(sequence);
  std::vector<Pose> with, without;
  for (const bool coarse_color : {true, false}) {
    Tracker tracker = tracker_of(sequence, mesh, coarse_color);
    tracker.reset(sequence.poses().front());
    for (const cv::Mat& frame : frames) {
      (coarse_color ? with : without).push_back(tracker.track(test::view_of(frame)).T_camera_object);
    }
  }
  CHECK(std::equal(with.begin(), with.end(), without.begin(), without.end(),
                   [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }));
}
