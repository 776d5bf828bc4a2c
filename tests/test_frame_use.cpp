// What a frame leaves behind in a tracker: what track() found in it, and nothing else.
#include <doctest/doctest.h>

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/check_error.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using test::box;
using test::clutter;
using test::error_of;
using test::paper_camera;
using test::pose_error;
using test::view_of;

const Sequence& sequence() {
  static const Sequence made(box(), paper_camera(4, 3, 29));
  return made;
}

const std::vector<cv::Mat>& frames() {
  static const std::vector<cv::Mat> made = test::frames_of(sequence());
  return made;
}

/// The box by texture, and by its outline alone.
std::vector<std::pair<std::string, Mesh>> models() {
  Mesh bare = box();
  bare.materials.clear();
  bare.triangle_materials.clear();
  return {{"texture", box()}, {"outline", bare}};
}

/// Two trackers of one model, at the first pose.
struct Pair {
  explicit Pair(const Mesh& mesh) : one(mesh, sequence().camera()), other(mesh, sequence().camera()) {
    one.reset(sequence().pose(0));
    other.reset(sequence().pose(0));
  }
  /// Both find the same to the last bit, which is not nothing.
  void check_same(const FrameResult& a, const FrameResult& b) const {
    CHECK(a.status == b.status);
    CHECK(a.T_camera_object.matrix() == b.T_camera_object.matrix());
    CHECK(a.information == b.information);
    CHECK(a.visible_pixels == b.visible_pixels);
    CHECK(one.pixel_mask().classes == other.pixel_mask().classes);
    CHECK(one.rendered_view().rgba == other.rendered_view().rgba);
  }

  Tracker one, other;
};

}  // namespace

TEST_CASE("the caller's memory is the caller's again when track() returns") {
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    Pair trackers(mesh);
    cv::Mat memory(frames()[0].size(), CV_8UC3);
    for (const cv::Mat& frame : frames()) {
      frame.copyTo(memory);
      const FrameResult result = trackers.one.track(view_of(memory));
      memory.setTo(cv::Scalar(255, 0, 255));
      CHECK(result.status == Status::held);
      trackers.check_same(result, trackers.other.track(view_of(frame)));
    }
  }
}

TEST_CASE("a frame that is refused leaves no trace") {
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    Pair trackers(mesh);
    const cv::Mat narrow(sequence().camera().height, sequence().camera().width - 1, CV_8UC3, cv::Scalar::all(90));
    for (const cv::Mat& frame : frames()) {
      CHECK(error_of([&] { trackers.one.track(view_of(narrow)); }).code == ErrorCode::image);
      CHECK(error_of([&] { trackers.one.refine(view_of(narrow), sequence().pose(0)); }).code == ErrorCode::image);
      trackers.check_same(trackers.one.track(view_of(frame)), trackers.other.track(view_of(frame)));
    }
  }
}

TEST_CASE("refine() on a tracker that has lost its object judges the pose given, and finds nothing for it") {
  Pair trackers(box());
  const cv::Mat empty = clutter(sequence().camera());
  for (Tracker* tracker : {&trackers.one, &trackers.other}) {
    CHECK(tracker->track(view_of(frames()[0])).status == Status::held);
    CHECK(tracker->track(view_of(empty)).status == Status::lost);
  }
  const FrameResult refined = trackers.one.refine(view_of(frames()[1]), sequence().pose(1));
  CHECK(refined.status == Status::held);
  CHECK(refined.reason.empty());
  CHECK(pose_error(sequence().pose(1), refined.T_camera_object).millimetres < 1);
  CHECK(trackers.one.refine(view_of(empty), sequence().pose(1)).status == Status::lost);
  trackers.check_same(trackers.one.track(view_of(empty)), trackers.other.track(view_of(empty)));
}

TEST_CASE("refine() between frames changes nothing") {
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    Pair trackers(mesh);
    for (int i = 0; i < sequence().size(); ++i) {
      CAPTURE(i);
      const FrameResult refined = trackers.one.refine(view_of(frames()[i]), sequence().pose(i));
      CHECK(refined.status == Status::held);
      trackers.one.refine(view_of(frames()[0]), sequence().pose(3));
      trackers.check_same(trackers.one.track(view_of(frames()[i])), trackers.other.track(view_of(frames()[i])));
    }
  }
}

TEST_CASE("reset() starts anew though the view and the mask of before were looked at") {
  Pair trackers(box());
  for (const cv::Mat& frame : frames()) trackers.one.track(view_of(frame));
  CHECK_FALSE(trackers.one.rendered_view().rgba.empty());
  CHECK_FALSE(trackers.one.pixel_mask().classes.empty());
  trackers.one.reset(sequence().pose(0));
  for (const cv::Mat& frame : frames()) {
    trackers.check_same(trackers.one.track(view_of(frame)), trackers.other.track(view_of(frame)));
  }
}
