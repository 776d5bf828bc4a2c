// What a tracker knows when it is new: nothing. What it sees to warm up, and what it saw before reset(), changes no bit
// of what it finds.
#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using test::view_of;

const Mesh& box() {
  static const Mesh mesh = simulation::textured_box();
  return mesh;
}

const Sequence& sequence() {
  static const Sequence made(box(), [] {
    simulation::SequenceOptions options = test::noisy_box(8, 41, 0.6, 0.9);
    options.sensor.gain = 0.7;  // photometry has something to find
    options.sensor.white_balance_stops = 0.3;
    options.sensor.change_frames = 16;
    return options;
  }());
  return made;
}

/// Every quality, and the accurate one with most of its parts off, which warms up less.
std::vector<std::pair<std::string, TrackerOptions>> modes() {
  TrackerOptions plain;
  plain.motion_blur = plain.light_compensation = plain.contour = plain.recovery = false;
  plain.ablate = {"shift_search", "shading"};
  plain.levels = 1;
  return {{"accurate", {}}, {"fast", TrackerOptions::fast()}, {"paper", TrackerOptions::paper()}, {"plain", plain}};
}

void check_same(const FrameResult& a, const FrameResult& b) {
  CHECK(a.T_camera_object.matrix() == b.T_camera_object.matrix());
  CHECK(a.covariance == b.covariance);
  CHECK(a.information == b.information);
  CHECK(a.status == b.status);
  CHECK(a.reason == b.reason);
  CHECK(a.message == b.message);
  CHECK(a.visible_pixels() == b.visible_pixels());
  CHECK(a.texture.usable_pixels == b.texture.usable_pixels);
  CHECK(a.texture.gradient_pixels == b.texture.gradient_pixels);
  CHECK(a.texture.passed_pixels == b.texture.passed_pixels);
  CHECK(a.texture.used_pixels == b.texture.used_pixels);
  CHECK(a.texture.rows == b.texture.rows);
  CHECK(a.texture.residual == b.texture.residual);
  CHECK(a.texture.correlation == b.texture.correlation);
  CHECK(a.contour.lines == b.contour.lines);
  CHECK(a.contour.near_lines == b.contour.near_lines);
  CHECK(a.contour.agreement == b.contour.agreement);
  CHECK(a.iterations == b.iterations);
}

/// The sequence from its first pose on, and the mask of each frame.
std::vector<std::pair<FrameResult, PixelMask>> run(Tracker& tracker) {
  tracker.reset(sequence().pose(0));
  std::vector<std::pair<FrameResult, PixelMask>> results;
  for (int i = 0; i < sequence().size(); ++i) {
    const FrameResult result = tracker.track(view_of(sequence().frame(i)));
    results.emplace_back(result, tracker.pixel_mask());
  }
  return results;
}

}  // namespace

TEST_CASE("the first frames of a new tracker are those after reset(), bit for bit") {
  for (const auto& [mode, options] : modes()) {
    CAPTURE(mode);
    Tracker tracker(box(), sequence().camera(), options);
    const auto at_first = run(tracker);
    CHECK(at_first.front().first.status == Status::held);
    // Meanwhile it sees something else, is lost, and searches.
    cv::Mat noise(sequence().camera().height, sequence().camera().width, CV_8UC3);
    cv::theRNG().state = 7;
    cv::randu(noise, 0, 255);
    for (int i = 0; i < 3; ++i) tracker.track(view_of(noise));
    const auto again = run(tracker);
    for (std::size_t i = 0; i < at_first.size(); ++i) {
      CAPTURE(i);
      check_same(at_first[i].first, again[i].first);
      CHECK(at_first[i].second.classes == again[i].second.classes);
    }
  }
}

TEST_CASE("warming up changes no pose") {
  const cv::Mat frame = sequence().frame(0);
  const Pose T_start = sequence().pose(0);
  for (const auto& [mode, options] : modes()) {
    CAPTURE(mode);
    // A new tracker refines without reset(): nothing but the warm-up lies behind it.
    Tracker fresh(box(), sequence().camera(), options), reset(box(), sequence().camera(), options);
    const FrameResult found = fresh.refine(view_of(frame), T_start);
    CHECK(found.status == Status::held);
    // The same as after a reset, which forgets whatever there is.
    reset.reset(T_start);
    check_same(found, reset.refine(view_of(frame), T_start));
  }
}

TEST_CASE("before its first frame a tracker shows nothing, of the view that warmed it up neither") {
  const Tracker tracker(box(), sequence().camera());
  const PixelMask mask = tracker.pixel_mask();
  CHECK(mask.classes.size() == std::size_t{512} * 384);
  CHECK(std::count(mask.classes.begin(), mask.classes.end(), 0) == static_cast<std::ptrdiff_t>(mask.classes.size()));
  CHECK(tracker.rendered_view().T_camera_object.matrix() == Pose::Identity().matrix());
}
