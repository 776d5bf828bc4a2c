// Where the next frame's object is looked for.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "motion/motion_model.hpp"

namespace {

using namespace holdfast;

const Extent kExtent{{0.01, -0.02, 0.03}, 0.1};
const Camera kCamera{640, 480, 650, 650, 319.5, 239.5, {}};

/// Moved by hand: turning and swaying, about two seconds a period at 30 frames a second.
Pose swaying(int frame) {
  const double t = 0.1 * frame;
  Pose T = Pose::Identity();
  T.linear() = (Eigen::AngleAxisd(0.6 * std::sin(t), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(0.4 * std::sin(0.7 * t + 1), Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.08 * std::sin(0.9 * t), 0.05 * std::cos(1.1 * t), 0.7 + 0.06 * std::sin(0.5 * t));
  return T;
}

/// Turns back on its way at frame 20, all at once.
Pose bouncing(int frame) {
  Pose T = swaying(std::min(frame, 20));
  if (frame > 20) T.translation() += (frame - 20) * Eigen::Vector3d(-0.01, 0.01, 0);
  return T;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Misses {
  double accelerating = 0, steady = 0;  ///< medians, pixels
};

/// How far each prediction is from where the object is next, when it is found with errors of `noise` metres.
Misses misses(double noise) {
  MotionModel accelerating(kExtent, true), steady(kExtent, false);
  std::mt19937 random(5);
  std::normal_distribution<double> error(0, noise);
  std::vector<double> a, s;
  for (int frame = 0; frame < 200; ++frame) {
    const Pose truth = swaying(frame);
    if (frame > 20) {
      a.push_back(corner_motion(kExtent, kCamera, truth, accelerating.predicted()));
      s.push_back(corner_motion(kExtent, kCamera, truth, steady.predicted()));
    }
    Pose found = truth;
    found.translation() += Eigen::Vector3d(error(random), error(random), error(random));
    for (MotionModel* model : {&accelerating, &steady}) frame == 0 ? model->reset(found) : model->advance(found, true);
  }
  return {median(a), median(s)};
}

}  // namespace

TEST_CASE("smooth motion is foreseen closer when its velocity may go on changing; noise does not look like that") {
  const Misses exact = misses(0), noisy = misses(1e-3);
  CHECK(exact.steady > 0.5);
  CHECK(exact.accelerating < 0.5 * exact.steady);
  CHECK(noisy.accelerating < 1.1 * noisy.steady);
}

TEST_CASE("a sudden turn is not expected to go on") {
  MotionModel model(kExtent, true);
  model.reset(bouncing(0));
  for (int frame = 1; frame <= 21; ++frame) {
    model.advance(bouncing(frame), true);
    CAPTURE(frame);
    const double apart = corner_motion(kExtent, kCamera, model.predicted(), model.steadily_predicted());
    if (frame == 20) CHECK(apart > 0.1);
    if (frame == 21) CHECK(apart < 1e-9);
  }
  CHECK(corner_motion(kExtent, kCamera, model.predicted(), bouncing(22)) < 3);
}

TEST_CASE("from a pose that is not exact nothing is made of how the velocity changes") {
  MotionModel model(kExtent, true);
  model.reset(swaying(0));
  const auto apart = [&] { return corner_motion(kExtent, kCamera, model.predicted(), model.steadily_predicted()); };
  for (int frame = 1; frame <= 10; ++frame) model.advance(swaying(frame), true);
  CHECK(apart() > 0.1);
  model.advance(swaying(11), false);
  CHECK(apart() < 1e-9);
  model.advance(swaying(12), true);  // nothing was foreseen that could be compared with this one
  CHECK(apart() < 1e-9);
  for (int frame = 13; frame <= 15; ++frame) model.advance(swaying(frame), true);
  CHECK(apart() > 0.1);
}

TEST_CASE("a lost object goes on as it moved, or is where it is suspected") {
  MotionModel model(kExtent, true);
  model.reset(swaying(0));
  for (int frame = 1; frame <= 10; ++frame) model.advance(swaying(frame), true);
  const Pose next = model.predicted();
  CHECK_FALSE(model.goes_on_unseen());
  CHECK(model.supposed(true).isApprox(next, 1e-12));
  CHECK(model.supposed(false).isApprox(swaying(10), 1e-12));
  model.lose();
  const Pose step = next * swaying(10).inverse(), T_gone_on = step * next;
  // The same turn again, and the centre as far again.
  CHECK(model.supposed(true).linear().isApprox(T_gone_on.linear(), 1e-9));
  const auto center = [](const Pose& T) { return Eigen::Vector3d(T * kExtent.p_object_center); };
  const Eigen::Vector3d displacement = center(next) - center(swaying(10));
  CHECK((center(model.supposed(true)) - center(next) - displacement).norm() < 1e-12);
  model.suspect(swaying(14));
  CHECK(model.supposed(true).isApprox(swaying(14), 1e-12));
  model.lose();
  CHECK_FALSE(model.supposed(true).isApprox(swaying(14), 1e-3));
  // For a while: then it is taken to have stopped.
  CHECK(model.goes_on_unseen());
  for (int frame = 0; frame < 12; ++frame) model.lose();
  CHECK_FALSE(model.goes_on_unseen());
  model.reset(swaying(0));
  model.lose();
  CHECK_FALSE(model.goes_on_unseen());  // how it moves is not known
}
