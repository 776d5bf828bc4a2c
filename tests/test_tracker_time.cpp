// Frames with times: dropped ones, such as do not rise, and a first pose given together with its frame.
#include <doctest/doctest.h>

#include <opencv2/core.hpp>
#include <optional>
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
using test::paper_camera;
using test::pose_error;
using test::view_of;

constexpr int kFrames = 24;
constexpr double kInterval = 0.04;

/// The box crosses the picture by 6 mm, some 5 pixels, a frame.
Pose pose_at(double frame) {
  Pose pose = Pose::Identity();
  pose.linear() = simulation::MotionOptions::default_orientation();
  pose.translation() = Eigen::Vector3d(-0.07 + 0.006 * frame, 0.002 * frame - 0.02, 0.8);
  return pose;
}

const Sequence& steady() {
  static const Sequence made(box(), [] {
    SequenceOptions options = paper_camera(kFrames, 5, 61);
    for (int i = 0; i < kFrames; ++i) options.motion.T_camera_object.push_back(pose_at(i));
    return options;
  }());
  return made;
}

const std::vector<cv::Mat>& frames() {
  static const std::vector<cv::Mat> made = test::frames_of(steady());
  return made;
}

/// Follows these frames of the sequence; all are held, near the truth.
void follow(Tracker& tracker, const std::vector<int>& indices) {
  for (const int i : indices) {
    CAPTURE(i);
    const FrameResult result = tracker.track(view_of(frames()[static_cast<std::size_t>(i)]), kInterval * i);
    CHECK(result.status == Status::held);
    CHECK(pose_error(pose_at(i), result.T_camera_object).millimetres < 1);
  }
}

/// What is expected after these frames at a time, as a frame without the object shows it.
Pose expected_at(Tracker& tracker, double time) {
  const FrameResult result = tracker.track(view_of(clutter(steady().camera())), time);
  CHECK(result.status == Status::lost);
  return result.T_camera_object;
}

}  // namespace

TEST_CASE("after a dropped frame an object is expected twice as far") {
  std::vector<double> gone;
  for (const double later : {1.0, 2.0, 3.5}) {
    CAPTURE(later);
    Tracker tracker(box(), steady().camera());
    tracker.reset(pose_at(0));
    follow(tracker, {0, 1, 2, 3, 4, 5, 6, 7});
    const Pose expected = expected_at(tracker, kInterval * (7 + later));
    CHECK(pose_error(pose_at(7 + later), expected).millimetres < 1 * later);
    gone.push_back((expected.translation() - pose_at(7).translation()).norm());
  }
  CHECK(gone[1] == doctest::Approx(2 * gone[0]).epsilon(0.1));
  CHECK(gone[2] == doctest::Approx(3.5 * gone[0]).epsilon(0.1));
}

TEST_CASE("frames at any interval are followed, and as easily as all of them where their times are told") {
  Tracker timed(box(), steady().camera());
  timed.reset(pose_at(0));
  follow(timed, {0, 1, 2, 4, 5, 9, 10, 13, 17, 18, 20, 23});
}

TEST_CASE("times that do not rise are refused, and leave no trace") {
  Tracker one(box(), steady().camera()), other(box(), steady().camera());
  one.reset(pose_at(0));
  other.reset(pose_at(0));
  for (int i = 0; i < 6; ++i) {
    const ImageView frame = view_of(frames()[static_cast<std::size_t>(i)]);
    const FrameResult a = one.track(frame, kInterval * i), b = other.track(frame, kInterval * i);
    CHECK(a.T_camera_object.matrix() == b.T_camera_object.matrix());
    CHECK_ERROR(one.track(frame, kInterval * i), ErrorCode::invalid_argument, "times must rise");
    CHECK_ERROR(one.track(frame, kInterval * (i - 1)), ErrorCode::invalid_argument, "times must rise");
    CHECK_ERROR(one.track(frame, std::numeric_limits<double>::quiet_NaN()), ErrorCode::invalid_argument, "times");
    CHECK_ERROR(one.track(frame, std::numeric_limits<double>::infinity()), ErrorCode::invalid_argument, "times");
  }
  // reset() begins anew.
  one.reset(pose_at(0));
  CHECK(one.track(view_of(frames()[0]), -3.0).status == Status::held);
  one.reset(pose_at(0), view_of(frames()[0]), 100.0);
  CHECK_ERROR(one.track(view_of(frames()[1]), 100.0), ErrorCode::invalid_argument, "times must rise");
  CHECK(one.track(view_of(frames()[1]), 100.04).status == Status::held);
}

TEST_CASE("frames with and without times cannot be mixed") {
  Tracker tracker(box(), steady().camera());
  for (const bool timed_first : {false, true}) {
    CAPTURE(timed_first);
    const auto time = [&](bool timed, int i) { return timed ? std::optional(kInterval * i) : std::nullopt; };
    tracker.reset(pose_at(0));
    tracker.track(view_of(frames()[0]), time(timed_first, 0));
    CHECK_ERROR(tracker.track(view_of(frames()[1]), time(!timed_first, 1)), ErrorCode::invalid_argument, "time");
  }
}

TEST_CASE("frames one apart and frames without times give the same poses") {
  Tracker timed(box(), steady().camera()), counted(box(), steady().camera());
  timed.reset(pose_at(0));
  counted.reset(pose_at(0));
  for (int i = 0; i < 8; ++i) {
    const ImageView frame = view_of(frames()[static_cast<std::size_t>(i)]);
    CHECK(timed.track(frame, i + 1).T_camera_object.matrix() == counted.track(frame).T_camera_object.matrix());
  }
}

TEST_CASE("a pose given with its frame: the next frame is held, and as near as one in a row") {
  for (const bool textured : {true, false}) {
    CAPTURE(textured);
    Mesh mesh = box();
    if (!textured) {
      mesh.materials.clear();
      mesh.triangle_materials.clear();
    }
    Tracker followed(mesh, steady().camera()), given(mesh, steady().camera());
    followed.reset(pose_at(2));
    given.reset(pose_at(2), view_of(frames()[2]), 2 * kInterval);
    followed.track(view_of(frames()[2]), 2 * kInterval);
    double worst_followed = 0, worst_given = 0;
    for (int i = 3; i < 8; ++i) {
      CAPTURE(i);
      const ImageView frame = view_of(frames()[static_cast<std::size_t>(i)]);
      const FrameResult a = followed.track(frame, kInterval * i), b = given.track(frame, kInterval * i);
      CHECK(b.status == Status::held);
      worst_followed = std::max(worst_followed, pose_error(pose_at(i), a.T_camera_object).millimetres);
      worst_given = std::max(worst_given, pose_error(pose_at(i), b.T_camera_object).millimetres);
    }
    MESSAGE("worst, mm: from the pose alone ", worst_followed, ", with its frame ", worst_given);
    CHECK(worst_given < 1.5 * worst_followed + 0.5);
  }
}
