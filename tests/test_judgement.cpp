// The words of a verdict, each from figures that call for it.
#include <doctest/doctest.h>

#include <cmath>

#include "judge/judgement.hpp"

namespace {

using namespace holdfast;

/// A view that is seen in full and agrees.
Estimate fine() {
  Estimate estimate;
  estimate.solved = true;
  estimate.correlation = 0.98;
  estimate.sums.visible = 10000;
  estimate.sums.usable = 9000;
  estimate.sums.gradient = 5000;
  estimate.sums.used = 3500;
  estimate.covariance = 1e-4 * Matrix6::Identity();  // of 0.6 degrees
  return estimate;
}

Circumstances usual() {
  Circumstances circumstances;
  circumstances.usual_share = 0.7;
  return circumstances;
}

}  // namespace

TEST_CASE("held: without a word when all is well, with one when it is hard") {
  Estimate estimate = fine();
  CHECK(judge(estimate, {}, usual()).status == Status::held);
  CHECK(judge(estimate, {}, usual()).reason.empty());

  Circumstances brighter = usual();
  brighter.gain = 1.6;
  CHECK(judge(estimate, {}, brighter).reason == "light changed");
  brighter.gain = 0.6;
  CHECK(judge(estimate, {}, brighter).reason == "light changed");

  Circumstances long_one = usual();
  long_one.misfit = Proportions::Misfit{2, 0, 0.0234};
  CHECK(judge(estimate, {}, long_one).status == Status::held);
  CHECK(judge(estimate, {}, long_one).reason == "model at least 2.3 % too large along z beside x");

  estimate.sums.used = 1050;  // of 3500 usual ones
  CHECK(judge(estimate, {}, usual()).status == Status::held);
  CHECK(judge(estimate, {}, usual()).reason == "occluded 70 %");
  Circumstances fast = usual();
  fast.blur_pixels = 12;
  CHECK(judge(estimate, {}, fast).reason == "blurred by 12 pixels");
  fast.blur_pixels = 400;  // then nothing could be seen
  CHECK(judge(estimate, {}, fast).reason == "occluded 70 %");

  // Wrong from the first pose on: little is all that is usual.
  Circumstances little = usual();
  little.usual_share = 0.13;
  estimate.sums.used = 600;
  CHECK(judge(estimate, {}, little).status == Status::held);
  CHECK(judge(estimate, {}, little).reason == "only 12 % of the texture agrees: hidden, or not this pose");
}

TEST_CASE("lost: the reason in words") {
  Estimate estimate = fine();
  estimate.sums.used = 175;
  CHECK(judge(estimate, {}, usual()).status == Status::lost);
  CHECK(judge(estimate, {}, usual()).reason == "occluded 95 %");
  Circumstances fast = usual();
  fast.predicted_pixels = 30;
  CHECK(judge(estimate, {}, fast).reason == "occluded, or motion too fast");

  estimate = fine();
  estimate.correlation = 0.3;
  CHECK(judge(estimate, {}, usual()).reason == "the frame does not look like the model");

  estimate = fine();
  estimate.sums.gradient = 10;
  estimate.solved = false;
  CHECK(judge(estimate, {}, usual()).reason == "no texture in view");

  estimate = Estimate();
  CHECK(judge(estimate, {}, usual()).reason == "out of view");
  Circumstances lost = usual();
  lost.lost_before = true;
  lost.searched_everywhere = true;
  CHECK(judge(estimate, {}, lost).reason == "found nowhere in the picture");
}

TEST_CASE("a sliver of an object that was held is held on to when it is sure") {
  Estimate sliver = fine();
  sliver.sums.used = 250;  // 5 % of the gradient pixels: half of what lost_visible_share asks for
  sliver.correlation = 0.99;
  sliver.deviation = 0.01;
  CHECK(judge(sliver, {}, usual()).status == Status::held);
  CHECK(judge(sliver, {}, usual()).reason == "occluded 93 %");

  Estimate open = sliver;
  open.deviation = 0.049;  // hardly less than what is expected without any pixel
  CHECK(judge(open, {}, usual()).status == Status::lost);
  Estimate few = sliver;
  few.sums.used = 30;
  CHECK(judge(few, {}, usual()).status == Status::lost);
  Estimate other = sliver;
  other.correlation = 0.9;
  CHECK(judge(other, {}, usual()).status == Status::lost);
  Circumstances lost = usual();
  lost.lost_before = true;
  CHECK(judge(sliver, {}, lost).status == Status::lost);
}

TEST_CASE("a handful of pixels that agree hold an object only where they tell its orientation") {
  Estimate estimate = fine();
  estimate.sums.gradient = 110;
  for (const double used : {20.0, 60.0, 99.0, 101.0}) {
    CAPTURE(used);
    estimate.sums.used = used;
    estimate.covariance = 1e-2 * Matrix6::Identity();  // of 6 degrees
    const Verdict unsure = judge(estimate, {}, usual());
    CHECK((unsure.status == Status::lost) == (used < 100));
    if (used < 100) CHECK(unsure.reason == "next to no texture in view");
    estimate.covariance = 1e-4 * Matrix6::Identity();
    CHECK(judge(estimate, {}, usual()).status == Status::held);
  }
}

TEST_CASE("to be found again takes more than to be held on to") {
  Estimate estimate = fine();
  estimate.sums.used = 1250;
  estimate.correlation = 0.93;
  Circumstances lost = usual();
  lost.lost_before = true;
  CHECK(judge(estimate, {}, usual()).status == Status::held);
  CHECK(judge(estimate, {}, lost).status == Status::lost);
  CHECK(judge(estimate, {}, lost).reason == "lost before, and not surely found again");
  CHECK(is_promising(estimate));
  // Behind an occluder less must do, if it agrees almost perfectly, where the object is expected.
  estimate.sums.used = 1750;
  estimate.correlation = 0.98;
  CHECK(is_probable(estimate));
  CHECK(judge(estimate, {}, lost).status == Status::lost);
  lost.expected = true;
  CHECK(judge(estimate, {}, lost).status == Status::held);
  lost.expected = false;
  // Elsewhere most of what is usual must be seen, or half of the texture in the view agree almost perfectly: another
  // part of the object may look like this one.
  estimate.sums.used = 2450;
  CHECK(judge(estimate, {}, lost).status == Status::lost);
  estimate.sums.used = 2550;
  CHECK(judge(estimate, {}, lost).status == Status::held);
  estimate.correlation = 0.95;
  estimate.sums.used = 2750;
  CHECK(judge(estimate, {}, lost).status == Status::lost);
  estimate.sums.used = 2850;
  CHECK(judge(estimate, {}, lost).status == Status::held);
}

TEST_CASE("found again by a part of it: where it is expected, if the part tells the pose") {
  Estimate part = fine();
  part.sums.used = 600;  // 12 % of the gradient pixels
  part.correlation = 0.99;
  part.deviation = 0.02;
  Circumstances lost = usual();
  lost.lost_before = lost.expected = true;
  CHECK(judge(part, {}, lost).status == Status::held);
  CHECK(judge(part, {}, lost).reason == "occluded 83 %");

  Circumstances elsewhere = lost;
  elsewhere.expected = false;
  CHECK(judge(part, {}, elsewhere).status == Status::lost);
  CHECK(is_promising(part));
  const auto check_lost = [&](const Estimate& estimate, bool promising) {
    CHECK(judge(estimate, {}, lost).status == Status::lost);
    CHECK(is_promising(estimate) == promising);
  };
  Estimate changed = part;
  changed.sums.used = 499;  // less than lost_visible_share
  check_lost(changed, true);
  changed.sums.used = 290;
  changed.sums.gradient = 2500;  // a share that would do, of few pixels
  check_lost(changed, true);
  changed.sums.used = 190;
  changed.sums.gradient = 1500;
  check_lost(changed, false);
  changed = part;
  changed.correlation = 0.97;
  check_lost(changed, false);
  changed = part;
  changed.deviation = 0.05;
  check_lost(changed, true);
  changed.deviation = 0.07;
  check_lost(changed, false);
  changed = part;
  changed.covariance = 9e-4 * Matrix6::Identity();  // 0.03 rad
  check_lost(changed, true);
  changed.covariance = 25e-4 * Matrix6::Identity();
  check_lost(changed, false);
}

TEST_CASE("to be held where it was not expected takes more") {
  Estimate estimate = fine();
  Circumstances surprising = usual();
  surprising.surprising = true;
  CHECK(judge(estimate, {}, surprising).status == Status::held);
  estimate.sums.used = 1000;
  CHECK(judge(estimate, {}, usual()).status == Status::held);
  CHECK(judge(estimate, {}, surprising).status == Status::lost);
  CHECK(judge(estimate, {}, surprising).reason == "occluded, or motion too fast");
  estimate.sums.used = 1300;
  CHECK(judge(estimate, {}, surprising).status == Status::held);
  estimate.correlation = 0.88;
  CHECK(judge(estimate, {}, surprising).status == Status::lost);
  estimate.sums.used = 2100;
  CHECK(judge(estimate, {}, surprising).status == Status::held);
}

TEST_CASE("a pose that nothing led to is believed only if its orientation is sure") {
  // About one axis, any: a strip of texture does not tell how it is turned about itself.
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 2).normalized();
  const auto turned_by = [&](double degrees) {
    Estimate estimate = fine();
    const double deviation = degrees * 3.14159265358979 / 180;
    estimate.covariance.bottomRightCorner<3, 3>() += deviation * deviation * axis * axis.transpose();
    return estimate;
  };
  CHECK(turned_by(2).turn_deviation() == doctest::Approx(std::hypot(0.01, 2 * 3.14159265358979 / 180)));
  Standing after_loss, jumped, followed;
  after_loss.lost_before = after_loss.expected = true;
  jumped.surprising = true;
  for (const Standing& standing : {after_loss, jumped}) {
    CHECK(is_good(turned_by(2), {}, standing));
    CHECK_FALSE(is_good(turned_by(3), {}, standing));
    Estimate unknown = fine();
    unknown.covariance.setZero();
    CHECK_FALSE(is_good(unknown, {}, standing));
  }
  CHECK(is_good(turned_by(10), {}, followed));
}
