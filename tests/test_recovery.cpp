// Lost objects are found again: behind an occluder that hides everything for 30 frames, and after leaving the picture,
// at poses turned by up to 40 degrees and moved from where they were last seen.
#include <doctest/doctest.h>

#include <cstdlib>
#include <random>
#include <vector>

#include "holdfast/tracker.hpp"
#include "keyframes.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"

namespace {

using namespace holdfast;

const Mesh& box() {
  static const Mesh mesh = simulation::textured_box();
  return mesh;
}

constexpr int kSeen = 12, kHidden = 30, kAfter = 18;
constexpr double kPi = 3.14159265358979323846;

Pose at(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& p_center) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = p_center - rotation * box().center().cast<double>();
  return pose;
}

/// Follows the object, loses it and finds it again: how many frames after it is half visible it is held, -1: not within
/// ten; and whether it was ever called held while it was far off.
struct Outcome {
  int frames = -1;
  bool wrong = false;
};

Outcome trial(unsigned seed, bool leaves) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto direction = [&] {
    Eigen::Vector3d v(uniform(random), uniform(random), uniform(random));
    while (v.norm() < 0.2) v = Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    return Eigen::Vector3d(v.normalized());
  };
  const Eigen::Matrix3d start = Eigen::AngleAxisd(0.5 * uniform(random), direction()).toRotationMatrix() *
                                simulation::MotionOptions::default_orientation();
  const Eigen::Vector3d axis = direction();
  const Eigen::Vector3d from(0.1 * uniform(random), 0.08 * uniform(random), 0.85 + 0.1 * uniform(random));
  const Eigen::Vector3d step(0.003 * uniform(random), 0.003 * uniform(random), 0.003 * uniform(random));
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd((20 + 20 * std::abs(uniform(random))) * kPi / 180, direction()).toRotationMatrix();
  const Eigen::Vector3d back(0.15 * uniform(random), 0.1 * uniform(random), from.z() * (1 + 0.1 * uniform(random)));
  simulation::SequenceOptions options;
  options.camera = {640, 480, 650, 650, 319.5, 239.5, {}};
  options.frames = kSeen + kHidden + kAfter;
  options.seed = seed;
  options.samples = 2;
  options.sensor.noise = 2;
  for (int i = 0; i < options.frames; ++i) {
    const Eigen::Matrix3d along = Eigen::AngleAxisd(0.02 * i, axis).toRotationMatrix();
    if (i < kSeen) {
      options.motion.T_camera_object.push_back(at(along * start, from + i * step));
    } else if (i < kSeen + kHidden) {
      const Eigen::Vector3d outside(leaves ? 3.0 : 0.0, 0, 0);
      options.motion.T_camera_object.push_back(at(along * start, from + kSeen * step + outside));
    } else {
      options.motion.T_camera_object.push_back(at(along * turn * start, back + (i - kSeen - kHidden) * step));
    }
  }
  if (!leaves) {
    // A board in front of everything, there in the hidden frames only.
    simulation::OccluderOptions board;
    board.kind = simulation::OccluderKind::mesh;
    board.mesh = simulation::textured_box();
    for (auto& position : board.mesh.positions) position *= 3;
    for (int i = 0; i < options.frames; ++i) {
      const bool hides = i >= kSeen && i < kSeen + kHidden;
      Pose pose = Pose::Identity();
      pose.translation() = Eigen::Vector3d(hides ? 0.0 : 5.0, 0, 0.62);
      board.T_camera_mesh.push_back(pose);
    }
    options.occluders.push_back(board);
  }
  const simulation::Sequence sequence(box(), options);
  Tracker tracker(box(), sequence.camera());
  tracker.reset(sequence.pose(0));
  Outcome outcome;
  int visible_frames = 0;
  for (int i = 0; i < sequence.size(); ++i) {
    const simulation::SimulatedFrame frame = sequence.make(i);
    const FrameResult result =
        tracker.track({frame.image.data, frame.image.cols, frame.image.rows, frame.image.step, PixelFormat::bgr8});
    const bool held = result.status == Status::held;
    const Eigen::Vector3d p_center = box().center().cast<double>();
    const bool right =
        (sequence.pose(i) * p_center - result.T_camera_object * p_center).norm() < 0.02 &&
        rotation_angle(sequence.pose(i).linear().transpose() * result.T_camera_object.linear()) < 5 * kPi / 180;
    if (i < kSeen) CHECK((held && right));
    if (i == kSeen + 4) CHECK(!held);
    if (held && !right) MESSAGE("frame ", i, " correlation ", result.correlation, " used ", result.used_pixels, " of ", result.gradient_pixels);
    outcome.wrong = outcome.wrong || (held && !right);
    if (i < kSeen + kHidden) continue;
    visible_frames += frame.visible_share >= 0.5;
    if (held && right) {
      outcome.frames = visible_frames;
      break;
    }
    if (visible_frames == 10) break;
  }
  return outcome;
}

void check_trials(bool leaves) {
  // More of them when asked for: the share found is published with 40.
  const char* more = std::getenv("HOLDFAST_TEST_TRIALS");
  const int trials = more != nullptr ? std::atoi(more) : 2;
  int found = 0, wrong = 0, frames = 0;
  for (int i = 0; i < trials; ++i) {
    const Outcome outcome = trial(static_cast<unsigned>(100 + i), leaves);
    found += outcome.frames >= 0;
    wrong += outcome.wrong;
    frames += std::max(0, outcome.frames);
  }
  MESSAGE(found, " of ", trials, " found, after ", static_cast<double>(frames) / std::max(1, found),
          " frames; called held while far off: ", wrong);
  CHECK(found >= 0.95 * trials);
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("found again after 30 frames behind a board") { check_trials(false); }
TEST_CASE("found again after leaving the picture") { check_trials(true); }

TEST_CASE("keyframes are spread: near ones replace each other, and the most crowded makes room") {
  Keyframes keyframes(Eigen::Vector3d(0.01, 0.02, 0.03));
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(0.1, -0.05, 0.7);
  keyframes.remember(pose);
  pose.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()));
  keyframes.remember(pose);
  CHECK(keyframes.count() == 1);
  pose.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  keyframes.remember(pose);
  CHECK(keyframes.count() == 2);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Quaterniond turned(normal(random), normal(random), normal(random), normal(random));
    pose.linear() = turned.normalized().toRotationMatrix();
    keyframes.remember(pose);
  }
  CHECK(keyframes.count() == 24);
  keyframes.clear();
  CHECK(keyframes.count() == 0);
}

TEST_CASE("a plan begins with the appearance last seen, centred, and covers all turns of 40 degrees within 25") {
  const Eigen::Vector3d p_object_center(0.01, 0.02, 0.03);
  Keyframes keyframes(p_object_center);
  Pose last = Pose::Identity();
  last.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  last.translation() = Eigen::Vector3d(0.2, -0.1, 0.8);
  keyframes.plan(last);
  std::vector<Pose> planned;
  for (int i = 0; i < 29; ++i) planned.push_back(keyframes.next());
  const Eigen::Vector3d p_center = planned[0] * p_object_center;
  CHECK(p_center.head<2>().norm() < 1e-9);
  CHECK(p_center.z() == doctest::Approx((last * p_object_center).norm()));
  // The same appearance: the view from the camera in the object's frame has not changed.
  const Eigen::Vector3d before = last.linear().transpose() * (last * p_object_center).normalized();
  const Eigen::Vector3d after = planned[0].linear().transpose() * p_center.normalized();
  CHECK((before - after).norm() < 1e-9);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  double farthest = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d axis(normal(random), normal(random), normal(random));
    const Eigen::Matrix3d there =
        Eigen::AngleAxisd(40 * kPi / 180, axis.normalized()).toRotationMatrix() * planned[0].linear();
    double nearest = 10;
    for (const Pose& pose : planned) nearest = std::min(nearest, rotation_angle(pose.linear().transpose() * there));
    farthest = std::max(farthest, nearest);
  }
  CHECK(farthest < 25 * kPi / 180);
}
