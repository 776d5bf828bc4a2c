// How much a frame takes, in solved systems: what has been found out is not found out again.
#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using test::view_of;

constexpr int kFrames = 30, kCoveredFrom = 12;

Sequence moving_box(double speed) {
  simulation::SequenceOptions options = test::noisy_box(kFrames, 52, 0.6, 0.9);
  options.motion.speed = speed;
  return {simulation::textured_box(), options};
}

/// Stripes over the object's left part, from its middle on, as they would move with it.
void cover(cv::Mat& frame, const Sequence& sequence, const Pose& T_camera_object) {
  const Camera& camera = sequence.camera();
  const Eigen::Vector2d middle = camera.project(T_camera_object.translation());
  const int right = static_cast<int>(middle.x());
  for (int x = 0; x < std::min(right, frame.cols); x += 12) {
    cv::rectangle(frame, {x, 0}, {std::min(x + 5, right), frame.rows}, {30, 90, 200}, cv::FILLED);
    cv::rectangle(frame, {std::min(x + 6, right), 0}, {std::min(x + 11, right), frame.rows}, {160, 60, 20}, cv::FILLED);
  }
}

struct Run {
  std::vector<int> solved;
  double worst_mm = 0;
};

/// From the first true pose on; all frames are checked to be held.
Run run(const Sequence& sequence, bool covered) {
  Tracker tracker(simulation::textured_box(), sequence.camera());
  tracker.reset(sequence.pose(0));
  Run result;
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const Pose truth = sequence.pose(i);
    cv::Mat frame = sequence.frame(i);
    if (covered && i >= kCoveredFrom) cover(frame, sequence, truth);
    const FrameResult found = tracker.track(view_of(frame));
    CHECK(found.status == Status::held);
    result.solved.push_back(found.iterations);
    result.worst_mm =
        std::max(result.worst_mm, 1e3 * (truth.translation() - found.T_camera_object.translation()).norm());
  }
  return result;
}

/// Covered frames that took more than five times what is usual in the open.
std::ptrdiff_t laborious(const Run& open, const Run& covered) {
  std::vector<int> usual(open.solved.begin() + kCoveredFrom, open.solved.end());
  std::nth_element(usual.begin(), usual.begin() + static_cast<std::ptrdiff_t>(usual.size() / 2), usual.end());
  const int many = 5 * usual[usual.size() / 2];
  return std::count_if(covered.solved.begin() + kCoveredFrom, covered.solved.end(),
                       [many](int solved) { return solved > many; });
}

}  // namespace

TEST_CASE("behind an occluder that stays, few frames look for something better in vain") {
  const Sequence sequence = moving_box(7);
  const Run open = run(sequence, false), covered = run(sequence, true);
  const std::ptrdiff_t many = laborious(open, covered);
  INFO("laborious frames: ", many, " of ", kFrames - kCoveredFrom, "; worst errors, mm: ", open.worst_mm,
       " in the open, ", covered.worst_mm, " behind the occluder");
  CHECK(many >= 1);  // it is unlike what was seen before, at first
  CHECK(many <= 3);
  CHECK(open.worst_mm < 1);
  CHECK(covered.worst_mm < 2);
}

TEST_CASE("a first pose that is right is found to be so at once, a wrong one is corrected as ever") {
  const Sequence sequence = moving_box(2);
  const cv::Mat frame = sequence.frame(0);
  const auto first = [&](const Pose& T_start) {
    Tracker tracker(simulation::textured_box(), sequence.camera());
    tracker.reset(T_start);
    return tracker.track(view_of(frame));
  };
  const Pose truth = sequence.pose(0);
  const FrameResult right = first(truth);
  CHECK(right.status == Status::held);
  CHECK(right.iterations <= 4);
  CHECK(1e3 * (right.T_camera_object.translation() - truth.translation()).norm() < 0.5);

  Pose off = truth;
  off.translation() += Eigen::Vector3d(0.008, -0.004, 0.004);
  off.linear() = Eigen::AngleAxisd(0.07, Eigen::Vector3d(1, 1, -1).normalized()) * truth.linear();
  const FrameResult wrong = first(off);
  CHECK(wrong.status == Status::held);
  CHECK(wrong.iterations > right.iterations);
  CHECK(1e3 * (wrong.T_camera_object.translation() - truth.translation()).norm() < 1);
}
