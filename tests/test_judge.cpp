// Which alignments are believed, and the words of a verdict, each from figures that call for it.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "judge/judge.hpp"

namespace {

using namespace holdfast;

constexpr double kDegree = M_PI / 180;

void set_deviation(Alignment& alignment, double deviation) {
  alignment.covariance = deviation * deviation * Matrix6::Identity();
}

/// A view whose texture is seen in full and agrees.
Alignment fine() {
  Alignment alignment;
  alignment.solved = alignment.has_texture = true;
  alignment.texture.correlation = 0.98;
  alignment.texture.reliability = 0.9;
  alignment.texture.sums.visible = 10000;
  alignment.texture.sums.usable = 9000;
  alignment.texture.sums.gradient = 5000;
  alignment.texture.sums.used = 3500;
  set_deviation(alignment, 0.01);
  return alignment;
}

/// A contour that is found all around, of an object whose texture does not count.
Alignment contour() {
  Alignment alignment;
  alignment.solved = alignment.has_contour = true;
  alignment.contour.found = true;
  alignment.contour.visible_pixels = 8000;
  alignment.contour.sums.lines = alignment.contour.sums.rows = 200;
  alignment.contour.sums.near = 190;
  alignment.contour.sums.agreement = 0.9;
  set_deviation(alignment, 0.01);
  return alignment;
}

/// The same with edges, of which this share sees one next to the model's.
Alignment with_edges(double near) {
  Alignment alignment = contour();
  alignment.has_edges = alignment.edges.found = true;
  alignment.edges.lines = 1000;
  alignment.edges.near = 1000 * near;
  return alignment;
}

AcceptanceContext usual() {
  AcceptanceContext context;
  context.expected = true;
  context.usual_inlier_ratio = 0.7;
  return context;
}

AcceptanceContext by_contour() {
  AcceptanceContext context = usual();
  context.texture_trust = 0;
  return context;
}

AcceptanceContext lost_before() {
  AcceptanceContext context = usual();
  context.lost_before = true;
  context.expected = false;
  return context;
}

Verdict verdict_of(const Alignment& alignment, const AcceptanceContext& context) {
  const Verdict verdict = judge(alignment, {}, context);
  CHECK((verdict.status == Status::held) == is_held(alignment, context));
  if (verdict.status == Status::lost) CHECK(verdict.reason != Reason::none);
  CHECK((verdict.reason == Reason::none) == verdict.message.empty());
  return verdict;
}

bool holds(const Alignment& alignment, const AcceptanceContext& context) {
  return verdict_of(alignment, context).status == Status::held;
}

}  // namespace

TEST_CASE("held: without a word when all is well, with one when it is hard") {
  Alignment alignment = fine();
  CHECK(holds(alignment, usual()));
  CHECK(verdict_of(alignment, usual()).reason == Reason::none);

  for (const double gain : {1.6, 0.6}) {
    AcceptanceContext other_light = usual();
    other_light.gain = gain;
    CHECK(holds(alignment, other_light));
    CHECK(verdict_of(alignment, other_light).reason == Reason::light_changed);
  }

  alignment.texture.sums.used = 1050;  // of 3500 usual ones
  CHECK(holds(alignment, usual()));
  CHECK(verdict_of(alignment, usual()).reason == Reason::occluded);
  CHECK(verdict_of(alignment, usual()).message == "occluded 70 %");
  AcceptanceContext fast = usual();
  fast.blur_pixels = 12;
  CHECK(verdict_of(alignment, fast).reason == Reason::too_fast);
  CHECK(verdict_of(alignment, fast).message == "blurred by 12 pixels");
  fast.blur_pixels = 400;  // then nothing could be seen
  CHECK(verdict_of(alignment, fast).message == "occluded 70 %");

  // Wrong from the first pose on: little is all that is usual.
  AcceptanceContext little = usual();
  little.usual_inlier_ratio = 0.13;
  alignment.texture.sums.used = 600;
  CHECK(holds(alignment, little));
  CHECK(verdict_of(alignment, little).reason == Reason::low_evidence);
}

TEST_CASE("lost: the reason, in words too") {
  Alignment alignment = fine();
  alignment.texture.sums.used = 175;
  alignment.texture.correlation = 0.9;
  CHECK_FALSE(holds(alignment, usual()));
  CHECK(verdict_of(alignment, usual()).reason == Reason::occluded);
  CHECK(verdict_of(alignment, usual()).message == "occluded 95 %");
  AcceptanceContext fast = usual();
  fast.predicted_pixels = 30;
  CHECK(verdict_of(alignment, fast).reason == Reason::too_fast);

  alignment = fine();
  alignment.texture.reliability = 0.1;
  CHECK(verdict_of(alignment, usual()).reason == Reason::low_evidence);

  alignment = fine();
  alignment.texture.sums.gradient = 10;
  alignment.texture.sums.used = 0;
  alignment.solved = false;
  CHECK(verdict_of(alignment, usual()).reason == Reason::no_evidence);

  alignment = {};
  alignment.has_texture = true;
  CHECK(verdict_of(alignment, usual()).reason == Reason::out_of_view);
  AcceptanceContext searched = lost_before();
  searched.searched_everywhere = true;
  CHECK(verdict_of(alignment, searched).message == "found nowhere in the picture");
}

TEST_CASE("a sliver of an object that was held is held on to when it is sure") {
  Alignment sliver = fine();
  sliver.texture.sums.used = 250;  // 5 % of the gradient pixels
  sliver.texture.correlation = 0.99;
  CHECK(holds(sliver, usual()));
  CHECK(verdict_of(sliver, usual()).message == "occluded 93 %");

  Alignment open = sliver;
  set_deviation(open, 0.049);
  CHECK_FALSE(holds(open, usual()));
  Alignment few = sliver;
  few.texture.sums.used = 30;
  CHECK_FALSE(holds(few, usual()));
  Alignment other = sliver;
  other.texture.correlation = 0.9;
  CHECK_FALSE(holds(other, usual()));
  CHECK_FALSE(holds(sliver, lost_before()));
  AcceptanceContext surprising = usual();
  surprising.surprising = true;
  CHECK_FALSE(holds(sliver, surprising));
}

TEST_CASE("a handful of pixels that agree hold an object only where they tell its orientation") {
  Alignment alignment = fine();
  alignment.texture.sums.gradient = 110;
  for (const double used : {20.0, 60.0, 99.0, 101.0}) {
    CAPTURE(used);
    alignment.texture.sums.used = used;
    set_deviation(alignment, 0.1);
    CHECK(holds(alignment, usual()) == (used > 100));
    if (used < 100) CHECK(verdict_of(alignment, usual()).message == "next to no texture in view");
    set_deviation(alignment, 0.01);
    CHECK(holds(alignment, usual()));
  }
}

TEST_CASE("a pixel or two that agree are no texture, however surely the contour tells the pose") {
  Alignment alignment = fine();
  alignment.texture.sums.gradient = 4;
  alignment.texture.sums.used = 3;
  CHECK_FALSE(is_held_by_texture(alignment, usual()));
  CHECK(verdict_of(alignment, usual()).reason == Reason::no_evidence);
}

TEST_CASE("to be found again takes more than to be held on to, and elsewhere more than where it is expected") {
  // What is enough, from the least to the most that is seen, must only grow with the doubt.
  AcceptanceContext expected = lost_before();
  expected.expected = true;
  const auto least = [](const AcceptanceContext& context) {
    for (double used = 0; used <= 5000; used += 50) {
      Alignment alignment = fine();
      alignment.texture.correlation = 0.93;
      alignment.texture.sums.used = used;
      if (is_held(alignment, context)) return used;
    }
    return 1e9;
  };
  CHECK(least(usual()) < least(expected));
  CHECK(least(expected) < least(lost_before()));
  CHECK(least(lost_before()) <= 3500);  // as much as is usual must do
  AcceptanceContext surprising = usual();
  surprising.surprising = true;
  CHECK(least(usual()) < least(surprising));

  Alignment alignment = fine();
  alignment.texture.sums.used = 1250;
  alignment.texture.correlation = 0.93;
  CHECK(verdict_of(alignment, lost_before()).reason == Reason::not_surely_found);
  CHECK(is_promising(alignment, lost_before()));
  Alignment chance = alignment;
  chance.texture.sums.used = 150;
  chance.texture.correlation = 0.2;
  CHECK(verdict_of(chance, lost_before()).reason == Reason::out_of_view);
  CHECK_FALSE(is_probable(alignment, lost_before()));
  alignment.texture.sums.used = 2100;
  CHECK(is_probable(alignment, lost_before()));
}

TEST_CASE("found again by a part of it: where it is expected, if the part tells the pose") {
  AcceptanceContext expected = lost_before();
  expected.expected = true;
  Alignment part = fine();
  part.texture.sums.used = 600;  // 12 % of the gradient pixels
  part.texture.correlation = 0.99;
  CHECK(holds(part, expected));
  CHECK(verdict_of(part, expected).message == "occluded 83 %");
  CHECK_FALSE(holds(part, lost_before()));
  CHECK(is_promising(part, expected));

  Alignment few = part;
  few.texture.sums.used = 290;
  few.texture.sums.gradient = 2500;  // a share that would do, of few pixels
  CHECK_FALSE(holds(few, expected));
  CHECK(is_promising(few, expected));
  Alignment unlike = part;
  unlike.texture.correlation = 0.89;
  CHECK_FALSE(holds(unlike, expected));
  CHECK_FALSE(is_promising(unlike, expected));
  Alignment unsure = part;
  set_deviation(unsure, 0.035);
  CHECK_FALSE(holds(unsure, expected));
}

TEST_CASE("a pose that nothing led to is believed only if its orientation is sure") {
  // About one axis, any: a strip of texture does not tell how it is turned about itself.
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 2).normalized();
  const auto turned_by = [&](double degrees) {
    Alignment alignment = fine();
    alignment.covariance.bottomRightCorner<3, 3>() += degrees * kDegree * degrees * kDegree * axis * axis.transpose();
    return alignment;
  };
  CHECK(turned_by(2).turn_deviation() == doctest::Approx(std::hypot(0.01, 2 * kDegree)));
  AcceptanceContext after_loss = lost_before(), jumped = usual();
  after_loss.expected = true;
  jumped.surprising = true;
  for (const AcceptanceContext& context : {after_loss, jumped}) {
    CHECK(holds(turned_by(2), context));
    CHECK_FALSE(holds(turned_by(3), context));
    Alignment unknown = fine();
    unknown.covariance.setZero();
    CHECK(unknown.turn_deviation() == std::numeric_limits<double>::infinity());
    CHECK_FALSE(holds(unknown, context));
  }
  CHECK(holds(turned_by(10), usual()));
}

TEST_CASE("a turn that does not show is told; where it never does, it does not speak against the pose") {
  Alignment alignment = fine();
  alignment.covariance(4, 4) = 1;
  alignment.texture.unobservable.observable(4, 4) = 0;
  alignment.texture.unobservable.count = 1;
  CHECK(alignment.turn_deviation() == doctest::Approx(1));
  CHECK(alignment.observable_turn_deviation() == doctest::Approx(0.01));
  CHECK(holds(alignment, usual()));
  CHECK(verdict_of(alignment, usual()).reason == Reason::ambiguous);
  for (const bool usually : {false, true}) {
    AcceptanceContext found = lost_before(), jumped = usual();
    found.expected = jumped.surprising = true;
    found.unobservable_usually = jumped.unobservable_usually = usually;
    CHECK(holds(alignment, found) == usually);
    CHECK(holds(alignment, jumped) == usually);
  }
  // What else is not sure still does.
  AcceptanceContext found = lost_before();
  found.expected = found.unobservable_usually = true;
  alignment.covariance(3, 3) = 0.01;
  CHECK_FALSE(holds(alignment, found));
}

TEST_CASE("a contour holds an object where it agrees as usual, and where it may have come to") {
  CHECK(holds(contour(), by_contour()));
  CHECK(verdict_of(contour(), by_contour()).reason == Reason::none);
  Alignment hidden = contour();
  hidden.contour.sums.near = 140;
  CHECK(holds(hidden, by_contour()));
  CHECK(verdict_of(hidden, by_contour()).reason == Reason::occluded);
  CHECK(verdict_of(hidden, by_contour()).message == "contour hidden 30 %");

  AcceptanceContext elsewhere = by_contour();
  elsewhere.expected = false;
  CHECK(verdict_of(contour(), elsewhere).reason == Reason::ambiguous);
  AcceptanceContext lost = elsewhere;
  lost.lost_before = true;
  CHECK(verdict_of(contour(), lost).reason == Reason::not_surely_found);
  Alignment elsewhere_edges = contour();
  elsewhere_edges.contour.sums.near = 30;
  CHECK(verdict_of(elsewhere_edges, lost).reason == Reason::out_of_view);

  Alignment weak = contour();
  weak.contour.sums.near = 60;
  CHECK(verdict_of(weak, by_contour()).reason == Reason::occluded);
  Alignment nothing = contour();
  nothing.contour.sums.rows = nothing.contour.sums.near = 0;
  CHECK(verdict_of(nothing, by_contour()).reason == Reason::no_evidence);
  Alignment beside = contour();
  beside.contour = {};
  beside.solved = false;
  CHECK(verdict_of(beside, by_contour()).reason == Reason::out_of_view);
}

TEST_CASE("where texture usually tells the pose, the contour alone needs more") {
  Alignment alignment = contour();
  alignment.has_texture = true;  // but nothing of it agrees
  alignment.texture.sums.visible = alignment.texture.sums.gradient = 5000;
  CHECK(holds(alignment, usual()));
  AcceptanceContext jumps = usual();
  jumps.jumps = true;
  CHECK_FALSE(holds(alignment, jumps));
  Alignment small = alignment;
  small.contour.visible_pixels = 500;
  CHECK_FALSE(holds(small, usual()));
  Alignment turned = alignment;
  set_deviation(turned, 0.1);
  CHECK_FALSE(holds(turned, usual()));
  for (Alignment& other : std::vector<Alignment>{small, turned}) {
    other.has_texture = false;
    CHECK(holds(other, by_contour()));
  }
}

TEST_CASE("edges that are next to the model's by chance alone score nothing, all of them 1") {
  CHECK(with_edges(1).edges.score() == doctest::Approx(1));
  CHECK(std::abs(with_edges(3.0 / 21).edges.score()) < 0.01);
  CHECK(Alignment().edges.score() == 0);
}

TEST_CASE("edges and contour count as much as they usually tell of the pose") {
  const Alignment alignment = with_edges(0.55);
  UsualOutline usual{0.855, 1, 0};
  CHECK(outline_score(alignment, usual) == doctest::Approx(0.975).epsilon(0.01));
  usual.edge_share = 1;
  CHECK(outline_score(alignment, usual) == doctest::Approx(alignment.edges.score()));
  usual.edge_share = 0.25;
  CHECK(outline_score(alignment, usual) ==
        doctest::Approx(0.25 * alignment.edges.score() + 0.75 * 0.975).epsilon(0.01));
  // As long as that is not known, as much as they tell here.
  usual.edge_share = -1;
  Alignment telling = alignment;
  telling.contour.equations.A = Matrix6::Identity();
  telling.edges.equations.A = 3 * Matrix6::Identity();
  CHECK(outline_score(telling, usual) == doctest::Approx(0.75 * alignment.edges.score() + 0.25 * 0.975).epsilon(0.01));

  Alignment only_edges = alignment, only_contour = alignment;
  only_edges.has_contour = only_contour.has_edges = false;
  CHECK(outline_score(only_edges, usual) == doctest::Approx(alignment.edges.score()));
  CHECK(outline_score(only_contour, usual) == doctest::Approx(0.975).epsilon(0.01));
  CHECK(outline_score({}, usual) == 0);
}

TEST_CASE(
    "edges alone hold an object, each of edges and contour counts as much as it usually tells, a first pose needs "
    "both") {
  AcceptanceContext context = by_contour();
  context.usual_outline = {0.855, 0.9, 0.3};
  CHECK(holds(with_edges(0.95), context));
  Alignment only_edges = with_edges(0.95);
  only_edges.has_contour = false;
  only_edges.contour = {};
  CHECK(is_held(only_edges, context));
  only_edges.edges.near = 0.4 * only_edges.edges.lines;
  CHECK_FALSE(is_held(only_edges, context));

  // The contour fits, the edges hardly: something like the object, or it has turned over.
  const Alignment no_edges = with_edges(0.35);
  CHECK(holds(no_edges, context));
  AcceptanceContext by_edges = context;
  by_edges.usual_outline.edge_share = 0.9;
  CHECK_FALSE(holds(no_edges, by_edges));

  // The edges fit, the contour does not.
  Alignment no_contour = with_edges(0.95);
  no_contour.contour.sums.near = 80;
  no_contour.contour.sums.agreement = 0.5;
  CHECK(outline_score(no_contour, by_edges.usual_outline) > 0.75);
  CHECK(holds(no_contour, by_edges));
  by_edges.first = true;
  CHECK_FALSE(holds(no_contour, by_edges));
  CHECK(holds(with_edges(0.95), by_edges));
}

TEST_CASE("to be found again by contour and edges most of the contour must be next to its edges") {
  AcceptanceContext lost = lost_before(), followed = by_contour();
  lost.expected = true;
  lost.texture_trust = 0;
  lost.usual_outline = followed.usual_outline = {0.855, 0.9, 0.7};
  Alignment alignment = with_edges(0.95);
  CHECK(holds(alignment, lost));
  CHECK(is_probable(alignment, lost));
  alignment.contour.sums.near = 150;
  CHECK(holds(alignment, followed));
  CHECK_FALSE(holds(alignment, lost));
  CHECK_FALSE(is_probable(alignment, lost));
  CHECK(is_promising(alignment, lost));
  followed.jumps = true;
  CHECK_FALSE(holds(alignment, followed));
  lost.expected = false;
  CHECK_FALSE(holds(with_edges(0.95), lost));
  // Where fewer of them are usually next to it, as many are enough.
  lost.expected = true;
  lost.usual_outline.near = 0.75;
  CHECK(holds(alignment, lost));
}

TEST_CASE(
    "a turn that neither texture nor contour shows: held in the first frame, where it is given, and not after it") {
  Alignment alignment = contour();
  alignment.has_texture = true;
  alignment.texture.sums.visible = alignment.texture.sums.gradient = 5000;
  AcceptanceContext context = by_contour();
  CHECK(holds(alignment, context));
  alignment.covariance(4, 4) = 0.3 * 0.3;
  CHECK(verdict_of(alignment, context).reason == Reason::ambiguous);
  CHECK_FALSE(holds(alignment, context));
  context.first = true;
  CHECK(holds(alignment, context));
  CHECK(verdict_of(alignment, context).message == "a turn does not show: known to 17 degrees (standard deviation)");
}

TEST_CASE("held by edges where no contour is found: no word of a texture that was not asked") {
  Alignment alignment = with_edges(0.95);
  alignment.has_texture = alignment.has_contour = false;
  AcceptanceContext context = by_contour();
  REQUIRE(holds(alignment, context));
  CHECK(verdict_of(alignment, context).message.empty());
  context.usual_inlier_ratio = 0.7;
  CHECK(verdict_of(alignment, context).message.empty());
}

TEST_CASE("what is left of a long thing tells next to nothing of where it is along itself: not held") {
  Alignment alignment = with_edges(0.95);
  alignment.has_texture = false;
  AcceptanceContext context = by_contour();
  CHECK(is_held(alignment, context));
  alignment.covariance(0, 0) = 0.3 * 0.3;
  CHECK(alignment.place_deviation() == doctest::Approx(0.3));
  CHECK_FALSE(is_held(alignment, context));
}

TEST_CASE("a snapshot alone does not find a lost object: its outline must show it, too") {
  Alignment alignment = with_edges(0.95);
  alignment.has_texture = false;
  alignment.has_snapshot = true;
  alignment.snapshot.reliability = 0.95;
  alignment.snapshot.sums.used = 1000;
  AcceptanceContext context = by_contour();
  context.sure_snapshot = true;
  CHECK(is_held_by_snapshot(alignment, context));
  alignment.contour.sums.near = 0.4 * alignment.contour.sums.lines;
  alignment.edges.near = 0.4 * alignment.edges.lines;
  CHECK(is_held_by_snapshot(alignment, context));
  context.lost_before = true;
  CHECK_FALSE(is_held_by_snapshot(alignment, context));
}
