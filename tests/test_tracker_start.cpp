// What a tracker knows when it is new: nothing. What it sees to warm up, and what it saw before reset(), changes no bit
// of what it finds.
#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"
#include "tracker/tracker_impl.hpp"

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

/// Every mode, and default mode with most of its parts off, which warms up less.
std::vector<std::pair<std::string, TrackerOptions>> modes() {
  TrackerOptions plain;
  plain.motion_blur = plain.correlation_search = plain.shading = plain.light_texels = plain.photometric = false;
  plain.texture_samples = 1;
  plain.levels = 1;
  return {{"default", {}},
          {"fast", TrackerOptions::fast()},
          {"paper", TrackerOptions::paper()},
          {"published", TrackerOptions::published()},
          {"plain", plain}};
}

void check_same(const FrameResult& a, const FrameResult& b) {
  CHECK(a.T_camera_object.matrix() == b.T_camera_object.matrix());
  CHECK(a.information == b.information);
  CHECK(a.status == b.status);
  CHECK(a.reason == b.reason);
  CHECK(a.visible_pixels == b.visible_pixels);
  CHECK(a.usable_pixels == b.usable_pixels);
  CHECK(a.gradient_pixels == b.gradient_pixels);
  CHECK(a.passed_pixels == b.passed_pixels);
  CHECK(a.used_pixels == b.used_pixels);
  CHECK(a.rows == b.rows);
  CHECK(a.residual == b.residual);
  CHECK(a.correlation == b.correlation);
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

TEST_CASE("warming up, once or again, changes no pose") {
  const cv::Mat frame = sequence().frame(0);
  const Pose T_start = sequence().pose(0);
  const auto refined = [&](Tracker::Impl& tracker) { return tracker.refine(view_of(frame), T_start); };
  for (const auto& [mode, options] : modes()) {
    CAPTURE(mode);
    // A new tracker refines without reset(): nothing but the warm-up lies behind it.
    Tracker::Impl once(box(), sequence().camera(), options, Device());
    const FrameResult found = refined(once);
    CHECK(found.status == Status::held);

    Tracker::Impl thrice(box(), sequence().camera(), options, Device());
    thrice.warm_up();
    thrice.warm_up();
    check_same(found, refined(thrice));

    // The same as after a reset, which forgets whatever there is.
    Tracker reset(box(), sequence().camera(), options);
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
