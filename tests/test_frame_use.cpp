// What a frame leaves behind in a tracker: what track() found in it, and nothing else.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
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
using simulation::SequenceOptions;
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

/// The box by texture, and by its contour alone.
std::vector<std::pair<std::string, Mesh>> models() {
  Mesh bare = box();
  bare.materials.clear();
  bare.triangle_materials.clear();
  return {{"texture", box()}, {"contour", bare}};
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
    CHECK(a.covariance == b.covariance);
    CHECK(a.information == b.information);
    CHECK(a.visible_pixels() == b.visible_pixels());
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
  const Camera& camera = sequence().camera();
  const cv::Mat narrow(camera.height, camera.width - 1, CV_8UC3, cv::Scalar::all(90));
  const ImageView good = view_of(frames()[0]);
  ImageView nothing = good, short_rows = good, foreign = good, endless_rows = good;
  foreign.format = static_cast<PixelFormat>(77);
  nothing.data = nullptr;
  short_rows.stride_bytes = 100;
  endless_rows.stride_bytes = std::size_t{1} << 62;  // rows times this is nothing in 64 bits
  Pose T_far = sequence().pose(0);
  T_far.translation() += Eigen::Vector3d(0.05, 0.02, 0.3);
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    Pair trackers(mesh);
    for (const cv::Mat& frame : frames()) {
      for (const ImageView& refused : {view_of(narrow), nothing, short_rows, endless_rows, foreign, ImageView{}}) {
        CHECK(error_of([&] { trackers.one.track(refused); }).code == ErrorCode::image);
        CHECK(error_of([&] { trackers.one.refine(refused, T_far); }).code == ErrorCode::image);
      }
      CHECK(error_of([&] { trackers.one.track(DeviceImageView{}); }).code == ErrorCode::image);
      trackers.check_same(trackers.one.track(view_of(frame)), trackers.other.track(view_of(frame)));
    }
  }
}

TEST_CASE("a first frame without the object, as cameras begin with, leaves nothing to follow instead of it") {
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    for (const int grey : {0, 128}) {
      CAPTURE(grey);
      Tracker tracker(mesh, sequence().camera());
      tracker.reset(sequence().pose(0));
      const cv::Mat empty(frames()[0].size(), CV_8UC3, cv::Scalar::all(grey));
      const FrameResult first = tracker.track(view_of(empty));
      CHECK(first.status == Status::lost);
      CHECK(first.reason != Reason::out_of_view);
      for (std::size_t i = 0; i < frames().size(); ++i) {
        CAPTURE(i);
        const FrameResult result = tracker.track(view_of(frames()[i]));
        if (i >= 2) CHECK(result.status == Status::held);
        if (result.status == Status::held) {
          CHECK(pose_error(sequence().pose(static_cast<int>(i)), result.T_camera_object).millimetres < 15);
        }
      }
    }
  }
}

TEST_CASE("view and mask are of the last frame, refine()'s too") {
  for (const auto& [name, mesh] : models()) {
    CAPTURE(name);
    Tracker tracker(mesh, sequence().camera());
    tracker.reset(sequence().pose(0));
    tracker.track(view_of(frames()[0]));
    const FrameResult refined = tracker.refine(view_of(frames()[2]), sequence().pose(2));
    CHECK(refined.ms.solve > 0);
    CHECK(refined.ms.total > refined.ms.solve + refined.ms.render);
    CHECK(pose_error(refined.T_camera_object, tracker.rendered_view().T_camera_object).millimetres < 1);
    const auto decided = [&] {
      const PixelMask mask = tracker.pixel_mask();
      return mask.classes.size() - static_cast<std::size_t>(std::count(mask.classes.begin(), mask.classes.end(), 0));
    };
    CHECK(decided() > 1000);
    if (name == "contour") continue;
    // Beside the picture there is nothing to decide.
    Pose T_beside = sequence().pose(0);
    T_beside.translation().x() += 5;
    CHECK(tracker.refine(view_of(frames()[1]), T_beside).reason == Reason::out_of_view);
    CHECK(decided() == 0);
    CHECK(tracker.track(view_of(frames()[1])).status == Status::held);
    CHECK(decided() > 1000);
  }
}

TEST_CASE("a long object is followed though its bounding cube reaches behind the camera") {
  simulation::BoxOptions board;
  board.size = Eigen::Vector3d(0.9, 0.2, 0.05);
  const Mesh mesh = simulation::textured_box(board);
  SequenceOptions options = paper_camera(8, 2, 43);
  for (int i = 0; i < options.frames; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() =
        (Eigen::AngleAxisd(0.004 * i, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
            .toRotationMatrix() *
        Eigen::Vector3d(1, -1, -1).asDiagonal();
    pose.translation() = Eigen::Vector3d(0.001 * i, 0, 0.26);
    options.motion.T_camera_object.push_back(pose);
  }
  const Sequence near(mesh, options);
  REQUIRE(mesh.radius() / std::sqrt(3.0) > 0.26);
  Tracker tracker(mesh, near.camera());
  tracker.reset(near.pose(0));
  for (int i = 0; i < near.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = near.frame(i);
    const FrameResult result = tracker.track(view_of(frame));
    CHECK(result.status == Status::held);
    CHECK(result.iterations < 40);
    CHECK(pose_error(near.pose(i), result.T_camera_object).millimetres < 0.3);
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
  CHECK(refined.reason == Reason::none);
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
