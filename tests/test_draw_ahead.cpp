// draw_ahead(): what track() finds is the same to the last bit, sooner.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using test::box;
using test::clutter;
using test::paper_camera;
using test::view_of;

constexpr int kFrames = 14;

/// Two trackers of one sequence, of which `one` draws ahead.
struct Pair {
  Pair(const Mesh& mesh, const Sequence& sequence, const TrackerOptions& options)
      : one(mesh, sequence.camera(), options), other(mesh, sequence.camera(), options) {
    one.reset(sequence.pose(0));
    other.reset(sequence.pose(0));
  }

  /// What `one` finds, the same as `other`.
  FrameResult track(const ImageView& frame) {
    const FrameResult a = one.track(frame), b = other.track(frame);
    CHECK(a.status == b.status);
    CHECK(a.T_camera_object.matrix() == b.T_camera_object.matrix());
    CHECK(a.information == b.information);
    CHECK(a.used_pixels == b.used_pixels);
    CHECK(b.ms.ahead == 0);
    return a;
  }

  Tracker one, other;
};

std::vector<std::pair<std::string, TrackerOptions>> modes() {
  return {{"default", {}},
          {"fast", TrackerOptions::fast()},
          {"paper", TrackerOptions::paper()},
          {"published", TrackerOptions::published()}};
}

}  // namespace

TEST_CASE("what is drawn ahead is what would be drawn, slow or fast, in every mode") {
  for (const double speed : {3.0, 14.0}) {
    const Sequence sequence(box(), paper_camera(kFrames, speed, 61));
    const std::vector<cv::Mat> frames = test::frames_of(sequence);
    for (const auto& [name, options] : modes()) {
      CAPTURE(name);
      CAPTURE(speed);
      Pair trackers(box(), sequence, options);
      int drawn_ahead = 0;
      bool held = false;  // the frame before
      for (std::size_t i = 0; i < frames.size(); ++i) {
        CAPTURE(i);
        const FrameResult result = trackers.track(view_of(frames[i]));
        const bool ahead = result.ms.ahead > 0;
        drawn_ahead += ahead ? 1 : 0;
        // Not the first, and none after a loss; where fast motion leads paper mode astray there may be none to draw.
        if (!held) CHECK_FALSE(ahead);
        if (held && (speed < 5 || options.mode != Mode::paper)) CHECK(ahead);
        held = result.status == Status::held;
        if (name == "published" && ahead) CHECK(result.ms.render == 0);  // it draws once
        CHECK(trackers.one.pixel_mask().classes == trackers.other.pixel_mask().classes);
        trackers.one.draw_ahead();
        const RenderedView view = trackers.one.rendered_view(), last = trackers.other.rendered_view();
        CHECK(view.T_camera_object.matrix() == last.T_camera_object.matrix());
        CHECK(view.rgba == last.rgba);
      }
      if (speed < 5) CHECK(drawn_ahead == kFrames - 1);
      if (name == "default" || name == "fast") CHECK(drawn_ahead == kFrames - 1);
    }
  }
}

TEST_CASE("what is asked of a tracker after it has drawn ahead is answered as ever") {
  const Sequence sequence(box(), paper_camera(kFrames, 4, 67));
  const std::vector<cv::Mat> frames = test::frames_of(sequence);
  Pair trackers(box(), sequence, {});
  auto next = [&, i = std::size_t{0}]() mutable { return trackers.track(view_of(frames[i++])); };
  trackers.one.draw_ahead();  // there is nothing to go by yet
  next();
  next();
  trackers.one.draw_ahead();
  const PixelMask mask = trackers.one.pixel_mask();
  CHECK(std::count(mask.classes.begin(), mask.classes.end(), static_cast<std::uint8_t>(PixelClass::used)) > 1000);
  CHECK(next().ms.ahead == 0);  // the last view was drawn again for the mask

  SUBCASE("refine()") {
    trackers.one.draw_ahead();
    trackers.one.refine(view_of(frames[5]), sequence.pose(5));
    CHECK(next().ms.ahead == 0);
  }
  SUBCASE("twice") {
    trackers.one.draw_ahead();
    trackers.one.draw_ahead();
    CHECK(trackers.one.rendered_view().T_camera_object.matrix() ==
          trackers.other.rendered_view().T_camera_object.matrix());
    CHECK(next().ms.ahead > 0);
  }
  SUBCASE("another texture") {
    Texture other = box().materials[0].texture;
    for (std::uint8_t& value : other.rgba) value = static_cast<std::uint8_t>(value / 2 + 100);
    trackers.one.draw_ahead();
    for (Tracker* tracker : {&trackers.one, &trackers.other}) tracker->set_texture(0, other);
    CHECK(trackers.one.rendered_view().rgba == trackers.other.rendered_view().rgba);
    CHECK(next().ms.ahead == 0);
  }
  SUBCASE("reset()") {
    trackers.one.draw_ahead();
    for (Tracker* tracker : {&trackers.one, &trackers.other}) tracker->reset(sequence.pose(3));
    CHECK(next().ms.ahead == 0);
  }
  SUBCASE("a grey frame") {
    cv::Mat grey;
    cv::extractChannel(frames[3], grey, 1);
    trackers.one.draw_ahead();
    ImageView view{grey.data, grey.cols, grey.rows, grey.step[0], PixelFormat::grey8};
    CHECK(trackers.track(view).ms.ahead == 0);
  }
  SUBCASE("a frame without the object") {
    const cv::Mat empty = clutter(sequence.camera());
    trackers.one.draw_ahead();
    CHECK(trackers.track(view_of(empty)).status == Status::lost);
    trackers.one.draw_ahead();
    CHECK(trackers.track(view_of(frames[3])).ms.ahead == 0);
  }
}

TEST_CASE("an object without texture has nothing to be drawn ahead") {
  Mesh bare = box();
  bare.materials.clear();
  bare.triangle_materials.clear();
  const Sequence sequence(box(), paper_camera(3, 3, 71));
  Pair trackers(bare, sequence, {});
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    CHECK(trackers.track(view_of(frame)).ms.ahead == 0);
    trackers.one.draw_ahead();
  }
}
