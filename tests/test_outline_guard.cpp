// A model whose texture comes from the frames, guarded by its outline.
#include <doctest/doctest.h>

#include <opencv2/core.hpp>

#include "baking/outline_guard.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

Pose moved(const Pose& T, double millimetres, double degrees) {
  Pose result = T;
  result.linear() = Eigen::AngleAxisd(degrees / kDegrees, Eigen::Vector3d(1, 0.5, -0.3).normalized()) * T.linear();
  result.translation() += 1e-3 * millimetres * Eigen::Vector3d(0.6, -0.4, 0.7);
  return result;
}

}  // namespace

TEST_CASE("a first pose that is off is put on the outline, and a tracker elsewhere is brought back to it") {
  int brought_back = 0;
  for (const std::uint64_t seed : {5, 6, 7}) {
    CAPTURE(seed);
    const simulation::Sequence sequence(box(), noisy_box(6, seed, 0.5, 0.7));
    const Device device;
    baking::OutlineGuard guard(box(), sequence.camera(), {}, device);
    const cv::Mat first = sequence.frame(0);
    const std::optional<Pose> found = guard.first_pose(view_of(first), moved(sequence.pose(0), 5, 3));
    REQUIRE(found);
    const PoseError error = pose_error(sequence.pose(0), *found);
    CHECK(error.millimetres < 2.5);
    CHECK(error.degrees < 1);

    Tracker tracker(box(), sequence.camera(), {}, device);
    tracker.reset(sequence.pose(0));
    for (int i = 0; i < 3; ++i) {
      const cv::Mat frame = sequence.frame(i);
      const FrameResult result = tracker.track(view_of(frame));
      const FrameResult checked = guard.check(tracker, view_of(frame), {}, result);
      CHECK(checked.T_camera_object.isApprox(result.T_camera_object));  // where both agree the tracker's is the better
    }
    const cv::Mat frame = sequence.frame(3);
    FrameResult drifted = tracker.track(view_of(frame));
    drifted.T_camera_object = moved(drifted.T_camera_object, 20, 6);
    const FrameResult checked = guard.check(tracker, view_of(frame), {}, drifted);
    brought_back += pose_error(sequence.pose(3), checked.T_camera_object).millimetres < 5;
    const cv::Mat next = sequence.frame(4);
    CHECK(pose_error(sequence.pose(4), tracker.track(view_of(next)).T_camera_object).millimetres < 2);
  }
  CHECK(brought_back >= 2);  // in the others the outline is not clear
}
