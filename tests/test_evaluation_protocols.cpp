// The evaluation's protocols on scripted trackers, and the pose errors they judge by.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "evaluation/pose_error.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/statistics.hpp"
#include "evaluation/summary.hpp"
#include "holdfast/error.hpp"
#include "support/evaluated.hpp"

using namespace holdfast;
using namespace holdfast::evaluation;
using namespace holdfast::test;

namespace {

/// A path along x, 10 mm a frame, at half a metre.
std::vector<Pose> straight_path(int frames) {
  std::vector<Pose> truth;
  for (int i = 0; i < frames; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(0.01 * i, 0, 0.5);
    truth.push_back(pose);
  }
  return truth;
}

/// Answers with the truth, but for the frames it is told to get wrong; writes down what it was asked.
struct ScriptedTracker {
  std::vector<Pose> truth;
  std::vector<int> wrong_frames;
  double wrong_by_mm = 60;
  bool stays_wrong = false;  ///< until it is reset
  std::vector<int> refuses_reset_at = {};

  std::vector<int> asked = {};
  std::vector<int> reset_to = {};  ///< frames whose true pose it was reset to
  bool wrong = false;

  int index_of(const Pose& pose) const {
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (truth[i].isApprox(pose)) {
        return static_cast<int>(i);
      }
    }
    return -1;
  }

  TrackerUnderTest tested() {
    return {.reset =
                [this](const Pose& pose) {
                  const int frame = index_of(pose);
                  for (const int refused : refuses_reset_at) {
                    if (refused == frame) {
                      throw Error(ErrorCode::pose, "out of view");
                    }
                  }
                  reset_to.push_back(frame);
                  wrong = false;
                },
            .track =
                [this](int frame) {
                  asked.push_back(frame);
                  bool now_wrong = wrong && stays_wrong;
                  for (const int wrong_frame : wrong_frames) {
                    now_wrong = now_wrong || wrong_frame == frame;
                  }
                  wrong = now_wrong;
                  FrameResult result;
                  result.status = Status::held;
                  result.T_camera_object = moved(truth[frame], now_wrong ? wrong_by_mm : 0, 0, 0);
                  result.ms.total = 1 + frame;
                  return result;
                }};
  }
};

std::vector<int> numbers_of(const std::vector<FrameRecord>& records, bool failed_only = false) {
  std::vector<int> frames;
  for (const FrameRecord& record : records) {
    if (!failed_only || record.failed) {
      frames.push_back(record.frame);
    }
  }
  return frames;
}

using Frames = std::vector<int>;

}  // namespace

TEST_CASE("an interrupted run answers with what it has") {
  ScriptedTracker tracker{.truth = straight_path(6), .wrong_frames = {}};
  ProtocolOptions options;
  options.is_interrupted = [&tracker] { return tracker.asked.size() == 3; };
  for (const Protocol protocol : {Protocol::never_reset, Protocol::rbot}) {
    tracker.asked.clear();
    options.protocol = protocol;
    CHECK(run_protocol(tracker.truth, {}, tracker.tested(), options).size() == 3);
  }
  tracker.asked.clear();
  StartOptions starts;
  starts.count = 4;
  starts.frames = 3;
  CHECK(run_starts(tracker.truth, {}, tracker.tested(), starts, options).size() == 1);
}

TEST_CASE("pose error: translation by axis, rotation by its angle") {
  Pose truth = Pose::Identity();
  truth.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  truth.translation() = Eigen::Vector3d(0.1, -0.2, 0.7);
  const PoseError error = pose_error(truth, moved(truth, 3, -4, -12, 0));
  CHECK(error.distance() == doctest::Approx(0.013));
  CHECK(error.lateral() == doctest::Approx(0.005));
  CHECK(error.depth() == doctest::Approx(0.012));
  CHECK(error.translation.z() == doctest::Approx(-0.012));
  CHECK(error.rotation < 1e-7);

  Pose turned = truth;
  turned.linear() = truth.linear() * Eigen::AngleAxisd(0.3, Eigen::Vector3d(-1, 1, 5).normalized()).toRotationMatrix();
  CHECK(pose_error(truth, turned).rotation == doctest::Approx(0.3));
  turned.linear() = truth.linear() * Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitX()).toRotationMatrix();
  CHECK(pose_error(truth, turned).rotation == doctest::Approx(3.14159));
}

TEST_CASE("pose error: a pose that is not finite is within no tolerance") {
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const PoseError error = pose_error(Pose::Identity(), broken);
  CHECK(std::isinf(error.distance()));
  CHECK_FALSE(tolerance_mm_deg(1e9, 1e9).holds(error));
}

TEST_CASE("tolerance: exceeding either bound is beyond, meeting both is within") {
  const Tolerance tolerance = tolerance_mm_deg(50, 5);
  const Pose origin = Pose::Identity();
  CHECK(tolerance.holds(pose_error(origin, moved(origin, 49.99, 0, 0, 4.99))));
  CHECK_FALSE(tolerance.holds(pose_error(origin, moved(origin, 50.01, 0, 0, 0))));
  CHECK_FALSE(tolerance.holds(pose_error(origin, moved(origin, 0, 0, 0, 5.01))));
  CHECK_FALSE(tolerance.holds(pose_error(origin, moved(origin, 30, 30, 30, 0))));  // 52 mm in all
}

TEST_CASE("quantiles interpolate linearly between neighbours") {
  CHECK(quantile({4, 1, 3, 2}, 0.5) == doctest::Approx(2.5));
  CHECK(quantile({5}, 0.95) == 5);
  CHECK(quantile({0, 10, 20, 30, 40}, 0.95) == doctest::Approx(38));  // position 3.8
  CHECK(quantile({1, 2, 3}, 1.0) == 3);
  CHECK(quantile({1, 2, 3}, 0.0) == 1);
  CHECK(std::isnan(quantile({}, 0.5)));
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(quantile({1, 2, inf}, 0.5) == 2);
  CHECK(quantile({1, 2, inf, inf}, 0.5) == inf);
}

TEST_CASE("never reset: every frame is asked for, the first one too, and nothing brings a reset") {
  ScriptedTracker tracker{.truth = straight_path(6), .wrong_frames = {2}, .stays_wrong = true};
  const auto records = run_protocol(tracker.truth, {}, tracker.tested(), {});
  CHECK(tracker.asked == Frames{0, 1, 2, 3, 4, 5});
  CHECK(tracker.reset_to == Frames{0});
  CHECK(numbers_of(records, true) == Frames{2, 3, 4, 5});
  const Summary summary = summarize(records, kRbotFailure);
  CHECK(summary.frames == 6);
  CHECK(summary.within_50mm_5deg.share == doctest::Approx(2.0 / 6));
  CHECK(summary.within_50mm_5deg.first_beyond == 2);
  CHECK(summary.within_50mm_5deg.frames_to_first_beyond == 2);
  CHECK(summary.confidently_wrong == 4);
  CHECK(summary.distance.maximum == doctest::Approx(0.06));
  CHECK(summary.distance_ok.maximum < 1e-12);
  CHECK(summary.ms_median == doctest::Approx(3.5));
}

TEST_CASE("rbot: starts after the first frame, a failure brings the truth of the failed frame") {
  ScriptedTracker tracker{.truth = straight_path(6), .wrong_frames = {2, 3}, .stays_wrong = true};
  const ProtocolOptions options{.protocol = Protocol::rbot};
  const auto records = run_protocol(tracker.truth, {}, tracker.tested(), options);
  CHECK(tracker.asked == Frames{1, 2, 3, 4, 5});
  CHECK(tracker.reset_to == Frames{0, 2, 3});
  CHECK(numbers_of(records, true) == Frames{2, 3});
  const Summary summary = summarize(records, kRbotFailure);
  CHECK(summary.frames == 5);
  CHECK(summary.failure.share == doctest::Approx(3.0 / 5));
  CHECK(summary.failure.first_beyond == 2);
  CHECK(summary.failure.frames_to_first_beyond == 1);
}

TEST_CASE("rbot: frames too little visible count neither way and bring no reset") {
  ScriptedTracker tracker{.truth = straight_path(7), .wrong_frames = {2, 4}, .stays_wrong = false};
  const std::vector<double> visible = {1, 1, 0.2, 0.25, 0.9, 0.1, 1};
  const ProtocolOptions options{.protocol = Protocol::rbot, .minimum_visible = 0.25};
  const auto records = run_protocol(tracker.truth, visible, tracker.tested(), options);
  CHECK(tracker.reset_to == Frames{0, 4});
  CHECK(numbers_of(records, true) == Frames{4});
  const Summary summary = summarize(records, kRbotFailure);
  CHECK(summary.frames == 4);  // 1, 3, 4, 6: a share equal to the bound counts
  CHECK(summary.skipped == 2);
  CHECK(summary.failure.share == doctest::Approx(3.0 / 4));
  CHECK(summary.failure.first_beyond == 4);
}

TEST_CASE("frame steps: every offset is a run of its own") {
  const std::vector<Pose> truth = straight_path(8);
  const std::vector<Frames> asked = {{3, 6}, {4, 7}, {5}};
  for (int offset = 0; offset < 3; ++offset) {
    ScriptedTracker tracker{.truth = truth, .wrong_frames = {}};
    const ProtocolOptions options{.protocol = Protocol::rbot, .step = 3, .offset = offset};
    const auto records = run_protocol(truth, {}, tracker.tested(), options);
    CHECK(tracker.asked == asked[offset]);
    CHECK(tracker.reset_to == Frames{offset});
    CHECK(numbers_of(records) == asked[offset]);
  }
  ScriptedTracker tracker{.truth = truth, .wrong_frames = {}};
  CHECK_THROWS_AS(run_protocol(truth, {}, tracker.tested(), {.step = 2, .offset = 2}), Error);
  CHECK_THROWS_AS(run_protocol(truth, {}, tracker.tested(), {.step = 0}), Error);
  const std::vector<double> too_few(7, 1.0);
  CHECK_THROWS_AS(run_protocol(truth, too_few, tracker.tested(), {}), Error);
}

TEST_CASE("frame steps: figures over all offsets") {
  const std::vector<Pose> truth = straight_path(10);
  std::vector<FrameRecord> all;
  for (int offset = 0; offset < 2; ++offset) {
    ScriptedTracker tracker{.truth = truth, .wrong_frames = {5, 6}};
    for (const FrameRecord& record :
         run_protocol(truth, {}, tracker.tested(), {.protocol = Protocol::rbot, .step = 2, .offset = offset})) {
      all.push_back(record);
    }
  }
  const Summary summary = summarize(all, kRbotFailure);
  CHECK(summary.frames == 8);  // 2 4 6 8 and 3 5 7 9
  CHECK(summary.failure.share == doctest::Approx(6.0 / 8));
  CHECK(summary.failure.first_beyond == 5);
  CHECK(summary.failure.frames_to_first_beyond == 1);  // frame 3, then 5
}

TEST_CASE("rbot: where the truth cannot be started from, the next failure tries again") {
  ScriptedTracker tracker{
      .truth = straight_path(6), .wrong_frames = {2}, .stays_wrong = true, .refuses_reset_at = {2, 3}};
  const auto records = run_protocol(tracker.truth, {}, tracker.tested(), {.protocol = Protocol::rbot});
  CHECK(numbers_of(records, true) == Frames{2, 3, 4});
  CHECK(tracker.reset_to == Frames{0, 4});
}

TEST_CASE(
    "rbot: a reset comes with the frame that it is the truth of, unless that is to be hidden; it is not counted") {
  for (const bool shown : {true, false}) {
    CAPTURE(shown);
    ScriptedTracker tracker{.truth = straight_path(4), .wrong_frames = {2}};
    TrackerUnderTest tested = tracker.tested();
    Frames shown_at;
    tested.reset_on = [&, reset = tested.reset](const Pose& pose, int frame) {
      CHECK(tracker.index_of(pose) == frame);
      shown_at.push_back(frame);
      reset(pose);
    };
    ProtocolOptions options{.protocol = Protocol::rbot};
    CHECK(options.show_start_frame);
    options.show_start_frame = shown;
    const auto records = run_protocol(tracker.truth, {}, tested, options);
    CHECK(tracker.asked == Frames{1, 2, 3});
    CHECK(tracker.reset_to == Frames{0, 2});
    CHECK(shown_at == (shown ? Frames{0, 2} : Frames{}));
    CHECK(numbers_of(records) == Frames{1, 2, 3});
  }
}

TEST_CASE("never-reset: the tracker is not shown the frame that it starts at, but asked for it") {
  ScriptedTracker tracker{.truth = straight_path(3), .wrong_frames = {}};
  TrackerUnderTest tested = tracker.tested();
  tested.reset_on = [](const Pose&, int) { FAIL("shown a frame"); };
  run_protocol(tracker.truth, {}, tested, {});
  CHECK(tracker.asked == Frames{0, 1, 2});
}

TEST_CASE("wrong starts: spread over the sequence, within the error asked for, judged on the last frame") {
  const std::vector<Pose> truth = straight_path(20);
  const StartOptions options{.count = 8, .translation = 0.004, .rotation = to_radians(3), .frames = 4, .seed = 7};
  const auto starts_of = [&](std::uint64_t seed, std::vector<FrameRecord>* records = nullptr) {
    ScriptedTracker scripted{.truth = truth, .wrong_frames = {7}};
    std::vector<Pose> starts;
    TrackerUnderTest tested = scripted.tested();
    tested.reset = [&](const Pose& pose) { starts.push_back(pose); };
    StartOptions seeded = options;
    seeded.seed = seed;
    const auto got = run_starts(truth, {}, tested, seeded, {});
    if (records != nullptr) {
      *records = got;
    }
    CHECK(scripted.asked.size() == 32);
    return starts;
  };
  std::vector<FrameRecord> records;
  const std::vector<Pose> starts = starts_of(7, &records);
  REQUIRE(starts.size() == 8);
  CHECK(numbers_of(records) == Frames{3, 5, 7, 9, 11, 13, 15, 17});  // 17 places of four frames, eight of them
  CHECK(numbers_of(records, true) == Frames{7});
  double farthest = 0, widest = 0;
  for (int i = 0; i < 8; ++i) {
    CHECK(records[i].offset == i);
    const PoseError error = pose_error(truth[2 * i], starts[i]);
    CHECK(error.distance() <= 0.004);
    CHECK(error.rotation <= to_radians(3) + 1e-12);
    farthest = std::max(farthest, error.distance());
    widest = std::max(widest, error.rotation);
  }
  CHECK(farthest > 0.002);
  CHECK(widest > to_radians(1.5));
  CHECK(starts_of(7)[3].isApprox(starts[3]));
  CHECK_FALSE(starts_of(8)[3].isApprox(starts[3]));
  ScriptedTracker tracker{.truth = truth, .wrong_frames = {}};
  CHECK_THROWS_AS(run_starts(truth, {}, tracker.tested(), {.frames = 21}, {}), Error);
}

TEST_CASE("confidently wrong: held and more than 20 mm or 5 degrees off; reported lost is not") {
  std::vector<FrameRecord> records(4);
  const Pose origin = Pose::Identity();
  const double off_mm[] = {19, 21, 0, 21};
  const double off_degrees[] = {4.9, 0, 5.1, 0};
  for (int i = 0; i < 4; ++i) {
    records[i].frame = i;
    records[i].error = pose_error(origin, moved(origin, off_mm[i], 0, 0, off_degrees[i]));
    records[i].result.status = i == 3 ? Status::lost : Status::held;
  }
  const Summary summary = summarize(records, kRbotFailure);
  CHECK(summary.confidently_wrong == 2);
  CHECK(summary.lost_frames == 1);
}
