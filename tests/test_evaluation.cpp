// The evaluation's metrics against values worked out by hand and brute force, its protocols on scripted trackers.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "evaluation/model_points.hpp"
#include "evaluation/nearest_point.hpp"
#include "evaluation/pose_error.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/report.hpp"
#include "evaluation/statistics.hpp"
#include "evaluation/summary.hpp"
#include "holdfast/error.hpp"

using namespace holdfast;
using namespace holdfast::evaluation;

namespace {

Pose moved(const Pose& pose, double x_mm, double y_mm, double z_mm, double degrees_about_z = 0) {
  Pose out = pose;
  out.pretranslate(Eigen::Vector3d(x_mm, y_mm, z_mm) * 1e-3);
  out.linear() =
      Eigen::AngleAxisd(to_radians(degrees_about_z), Eigen::Vector3d::UnitZ()).toRotationMatrix() * out.linear();
  return out;
}

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
    return {[this](const Pose& pose) {
              const int frame = index_of(pose);
              for (const int refused : refuses_reset_at) {
                if (refused == frame) {
                  throw Error(ErrorCode::pose, "out of view");
                }
              }
              reset_to.push_back(frame);
              wrong = false;
            },
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

const Tolerance kRbotFailure = tolerance_mm_deg(50, 5);

}  // namespace

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

TEST_CASE("rbot: the frame of a reset is shown on request, and not counted") {
  ScriptedTracker tracker{.truth = straight_path(4), .wrong_frames = {2}};
  const auto records =
      run_protocol(tracker.truth, {}, tracker.tested(), {.protocol = Protocol::rbot, .show_start_frame = true});
  CHECK(tracker.asked == Frames{0, 1, 2, 2, 3});
  CHECK(numbers_of(records) == Frames{1, 2, 3});
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

namespace {

std::vector<Eigen::Vector3d> random_points(int count, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(0.1 * normal(generator), 0.03 * normal(generator), 0.05 * normal(generator));
  }
  return points;
}

double nearest_by_brute_force(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& query) {
  double best = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& point : points) {
    best = std::min(best, (point - query).norm());
  }
  return best;
}

double add_s_by_brute_force(const std::vector<Eigen::Vector3d>& points, const Pose& truth, const Pose& estimated) {
  std::vector<Eigen::Vector3d> placed;
  for (const Eigen::Vector3d& point : points) {
    placed.push_back(estimated * point);
  }
  double sum = 0;
  for (const Eigen::Vector3d& point : points) {
    sum += nearest_by_brute_force(placed, truth * point);
  }
  return sum / static_cast<double>(points.size());
}

Pose random_pose(std::mt19937& generator, double translation, double rotation) {
  std::normal_distribution<double> normal;
  Twist twist;
  for (int i = 0; i < 6; ++i) {
    twist[i] = normal(generator) * (i < 3 ? translation : rotation);
  }
  return exp_se3(twist);
}

/// 200 x 100 x 40 mm, twelve triangles.
Mesh box_mesh() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(i & 1 ? 0.1f : -0.1f, i & 2 ? 0.05f : -0.05f, i & 4 ? 0.02f : -0.02f);
  }
  const unsigned quads[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& quad : quads) {
    mesh.triangles.push_back({quad[0], quad[1], quad[2]});
    mesh.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  return mesh;
}

/// The area under the accuracy curve as its definition says, by a fine sum.
double area_by_sum(const std::vector<double>& errors, double maximum) {
  constexpr int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double threshold = maximum * (i + 0.5) / steps;
    sum += static_cast<double>(std::count_if(errors.begin(), errors.end(), [=](double e) { return e < threshold; }));
  }
  return sum / steps / static_cast<double>(errors.size());
}

FrameRecord record_of(int frame, double off_mm, Status status = Status::held, double visible = 1) {
  FrameRecord record;
  record.frame = frame;
  record.result.status = status;
  record.result.T_camera_object = moved(record.T_camera_object_true, off_mm, 0, 0);
  record.error = pose_error(record.T_camera_object_true, record.result.T_camera_object);
  record.visible = visible;
  return record;
}

}  // namespace

TEST_CASE("nearest point: as brute force, on scattered, repeated and collinear points") {
  std::vector<Eigen::Vector3d> repeated(20, Eigen::Vector3d(0.1, 0.1, 0.1));
  repeated.emplace_back(0.2, 0.1, 0.1);
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 50; ++i) {
    line.emplace_back(0.01 * (i % 17), 0, 0);
  }
  const std::vector<std::vector<Eigen::Vector3d>> sets = {random_points(400, 1), repeated, line, random_points(1, 2)};
  for (const auto& points : sets) {
    const NearestPoint tree(points);
    for (const Eigen::Vector3d& query : random_points(200, 3)) {
      CHECK(tree.distance(query) == doctest::Approx(nearest_by_brute_force(points, query)).epsilon(1e-12));
      CHECK(tree.distance(10 * query) == doctest::Approx(nearest_by_brute_force(points, 10 * query)).epsilon(1e-12));
    }
  }
}

TEST_CASE("diameter: the largest of all distances") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const auto points = random_points(150, seed);
    double largest = 0;
    for (const auto& a : points) {
      for (const auto& b : points) {
        largest = std::max(largest, (a - b).norm());
      }
    }
    CHECK(diameter(points) == doctest::Approx(largest).epsilon(1e-12));
  }
  CHECK(diameter({Eigen::Vector3d(1, 2, 3)}) == 0);
  // The farthest point from the middle, (0, 1.4, 0), is no end of the diameter.
  std::vector<Eigen::Vector3d> lopsided(20, Eigen::Vector3d::Zero());
  lopsided.insert(lopsided.end(), {{0, 1.4, 0}, {0.875, 0, 0}, {-0.875, 0, 0}});
  CHECK(diameter(lopsided) == doctest::Approx(1.75));
  CHECK(ModelPoints(box_mesh()).diameter() == doctest::Approx(std::sqrt(0.2 * 0.2 + 0.1 * 0.1 + 0.04 * 0.04)));
}

TEST_CASE("ADD: by hand for a shift and for a turn about an axis") {
  const Pose origin = Pose::Identity();
  const ModelPoints shifted(random_points(100, 4), 1.0);
  CHECK(shifted.add(origin, moved(origin, 3, 4, 12)) == doctest::Approx(0.013));
  // Points at 100 mm and 20 mm from the axis: chords of 2 r sin(angle / 2).
  const ModelPoints two({Eigen::Vector3d(0.1, 0, 0.7), Eigen::Vector3d(0, -0.02, 0)}, 1.0);
  const double chord = 2 * std::sin(to_radians(30) / 2);
  CHECK(two.add(origin, moved(origin, 0, 0, 0, 30)) == doctest::Approx((0.1 * chord + 0.02 * chord) / 2));
}

TEST_CASE("ADD-S: as brute force; a square turned by 90 degrees is where it was") {
  std::mt19937 generator(5);
  const auto points = random_points(300, 6);
  const ModelPoints model(points, 1.0);
  for (int i = 0; i < 20; ++i) {
    const Pose truth = random_pose(generator, 0.5, 1.0);
    const Pose estimated = random_pose(generator, i % 2 ? 0.01 : 0.3, i % 2 ? 0.05 : 1.0) * truth;
    CHECK(model.add_s(truth, estimated) ==
          doctest::Approx(add_s_by_brute_force(points, truth, estimated)).epsilon(1e-10));
    CHECK(model.add_s(truth, estimated) <= model.add(truth, estimated));
  }
  const ModelPoints square({{1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}}, 2 * std::sqrt(2.0));
  const Pose origin = Pose::Identity();
  CHECK(square.add_s(origin, moved(origin, 0, 0, 0, 90)) < 1e-12);
  CHECK(square.add(origin, moved(origin, 0, 0, 0, 90)) == doctest::Approx(2));
}

TEST_CASE("ADD and ADD-S of a pose that is not finite are infinite") {
  Pose broken = Pose::Identity();
  broken.translation().z() = std::numeric_limits<double>::infinity();
  const ModelPoints model(box_mesh());
  CHECK(std::isinf(model.add(Pose::Identity(), broken)));
  CHECK(std::isinf(model.add_s(Pose::Identity(), broken)));
}

TEST_CASE("model points: distinct used vertices, or even cover of the surface where vertices are few") {
  const Mesh box = box_mesh();
  const auto points = points_of(box);
  CHECK(points.size() == 2000);
  // Every point lies on a face, and every pair of faces has its share of the area.
  const double area = 2 * (0.2 * 0.1 + 0.2 * 0.04 + 0.1 * 0.04);
  const double half[3] = {0.1, 0.05, 0.02};
  const double share[3] = {2 * 0.1 * 0.04 / area, 2 * 0.2 * 0.04 / area, 2 * 0.2 * 0.1 / area};
  int on_axis[3] = {};
  for (const Eigen::Vector3d& point : points) {
    int faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::abs(point[axis]) <= half[axis] + 1e-8);
      if (std::abs(std::abs(point[axis]) - half[axis]) < 1e-8) {
        ++faces;
        ++on_axis[axis];
      }
    }
    CHECK(faces >= 1);
  }
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(on_axis[axis] / 2000.0 == doctest::Approx(share[axis]).epsilon(0.01));
  }
  // Evenly: half the points lie on either side of each middle plane, and the mean square is that of the surface.
  double mean_square_x = 0;
  int right = 0;
  for (const Eigen::Vector3d& point : points) {
    mean_square_x += point.x() * point.x() / 2000.0;
    right += point.x() > 0 ? 1 : 0;
  }
  CHECK(right == doctest::Approx(1000).epsilon(0.02));
  CHECK(mean_square_x == doctest::Approx(0.01 * share[0] + 0.01 / 3 * (share[1] + share[2])).epsilon(0.02));

  Mesh fine;
  for (int i = 0; i < 600; ++i) {
    fine.positions.emplace_back(0.001f * static_cast<float>(i), 0.01f * static_cast<float>(i % 7), 0.0f);
  }
  fine.positions.emplace_back(9.0f, 9.0f, 9.0f);     // stray: no triangle uses it
  fine.positions.push_back(fine.positions.front());  // a seam's second copy
  for (unsigned i = 0; i + 2 < 600; ++i) {
    fine.triangles.push_back({i, i + 1, i + 2});
  }
  fine.triangles.push_back({601, 1, 2});
  CHECK(points_of(fine).size() == 600);
  CHECK(ModelPoints(fine).diameter() < 1);
}

TEST_CASE("accuracy over threshold: the area as its definition says") {
  const std::vector<double> errors = {0.0, 0.013, 0.013, 0.05, 0.099, 0.1, 0.4, 7};
  CHECK(area_under_accuracy(errors, 0.1) == doctest::Approx(area_by_sum(errors, 0.1)).epsilon(1e-3));
  CHECK(area_under_accuracy({0, 0}, 0.1) == doctest::Approx(1));
  CHECK(area_under_accuracy({0.2, 0.1}, 0.1) == doctest::Approx(0));
  CHECK(area_under_accuracy({0.05}, 0.1) == doctest::Approx(0.5));
  CHECK(area_under_accuracy({std::numeric_limits<double>::infinity(), 0}, 0.1) == doctest::Approx(0.5));
  CHECK(std::isnan(area_under_accuracy({}, 0.1)));
  CHECK(share_below({1, 2, 3, 4}, 3) == doctest::Approx(0.5));  // strictly below, as published
}

TEST_CASE("distance scores: thresholds and areas against the diameter") {
  std::vector<FrameRecord> records;
  const double add_mm[] = {1, 3, 7, 60, 300};
  for (int i = 0; i < 5; ++i) {
    records.push_back(record_of(i, 0));
    records.back().add = 1e-3 * add_mm[i];
    records.back().add_s = 0;
  }
  const Summary summary = summarize(records, kRbotFailure, 0.1);
  REQUIRE(summary.add);
  CHECK(summary.add->below_2_percent == doctest::Approx(0.2));
  CHECK(summary.add->below_5_percent == doctest::Approx(0.4));
  CHECK(summary.add->below_10_percent == doctest::Approx(0.6));
  CHECK(summary.add->auc_100mm == doctest::Approx(100 * (0.99 + 0.97 + 0.93 + 0.4) / 5));
  CHECK(summary.add->auc_opt == doctest::Approx(20 * (0.95 + 0.85 + 0.65) / 5));  // limit 20 mm
  CHECK(summary.add->distance.median == doctest::Approx(0.007));
  REQUIRE(summary.add_s);
  CHECK(summary.add_s->auc_opt == doctest::Approx(20));
  CHECK_FALSE(summarize(records, kRbotFailure).add);  // no diameter
  records[2].add = -1;
  CHECK_FALSE(summarize(records, kRbotFailure, 0.1).add);  // not computed for every frame
}

TEST_CASE("errors by axis: depth apart from lateral") {
  std::vector<FrameRecord> records(3);
  const double x_mm[] = {3, 0, -6};
  const double z_mm[] = {-1, 2, 5};
  for (int i = 0; i < 3; ++i) {
    records[i].frame = i;
    records[i].error = pose_error(Pose::Identity(), moved(Pose::Identity(), x_mm[i], 4, z_mm[i]));
  }
  const Summary summary = summarize(records, kRbotFailure);
  CHECK(summary.x.median == doctest::Approx(0.003));
  CHECK(summary.x.maximum == doctest::Approx(0.006));
  CHECK(summary.y.p95 == doctest::Approx(0.004));
  CHECK(summary.depth.median == doctest::Approx(0.002));
  CHECK(summary.depth.maximum == doctest::Approx(0.005));
  CHECK(summary.lateral.median == doctest::Approx(0.005));                    // 3, 4
  CHECK(summary.lateral.maximum == doctest::Approx(std::sqrt(52.0) * 1e-3));  // 6, 4
}

TEST_CASE("losses: stretches reported lost or beyond, and how long since the object could be seen again") {
  const double seen = 1, hidden = 0.2;
  const std::vector<FrameRecord> records = {
      record_of(0, 0),
      record_of(1, 60),                        // a loss without any occlusion: three frames
      record_of(2, 0, Status::lost),           // right but reported lost
      record_of(3, 70, Status::lost),          //
      record_of(4, 0),                         //
      record_of(5, 0, Status::lost, seen),     // lost before it is hidden
      record_of(6, 90, Status::lost, hidden),  //
      record_of(7, 90, Status::lost, hidden),  //
      record_of(8, 90, Status::lost, 0.5),     // visible again
      record_of(9, 90, Status::lost, 0.8),     //
      record_of(10, 1, Status::held, 0.9),     // back, two frames later
      record_of(11, 90, Status::lost, hidden),
      record_of(12, 1, Status::held, hidden),  // back before it is half visible
      record_of(13, 90, Status::lost, seen),   // for good
      record_of(14, 90, Status::lost, seen),
  };
  const Summary summary = summarize(records, kRbotFailure);
  REQUIRE(summary.losses.size() == 4);
  CHECK(summary.losses[0].first_frame == 1);
  CHECK(summary.losses[0].reacquired_frame == 4);
  CHECK(summary.losses[0].frames == 3);
  CHECK(summary.losses[0].frames_since_visible == 3);
  CHECK(summary.losses[1].first_frame == 5);
  CHECK(summary.losses[1].reacquired_frame == 10);
  CHECK(summary.losses[1].frames == 5);
  CHECK(summary.losses[1].frames_since_visible == 2);
  CHECK(summary.losses[2].reacquired_frame == 12);
  CHECK(summary.losses[2].frames_since_visible == 0);
  CHECK_FALSE(summary.losses[3].reacquired_frame);
  CHECK(summary.losses[3].frames == 2);
  CHECK(summary.losses[3].frames_since_visible == 2);
}

TEST_CASE("losses: an offset's last loss does not run on into the next offset") {
  std::vector<FrameRecord> records = {record_of(0, 0), record_of(2, 90), record_of(1, 0), record_of(3, 90)};
  for (FrameRecord& record : records) {
    record.step = 2;
    record.offset = record.frame % 2;
  }
  const Summary summary = summarize(records, kRbotFailure);
  REQUIRE(summary.losses.size() == 2);
  CHECK_FALSE(summary.losses[0].reacquired_frame);
  CHECK_FALSE(summary.losses[1].reacquired_frame);
}

TEST_CASE("normalised error: the information matrix is about T_true = exp(xi) T_estimated, camera axes") {
  std::mt19937 generator(7);
  const Pose estimated = random_pose(generator, 0.4, 1.0);
  Twist xi;
  xi << 0.001, -0.002, 0.004, 0.01, 0.02, -0.005;
  Matrix6 information = Matrix6::Zero();
  information.diagonal() << 1e6, 2e6, 1e5, 1e4, 2e4, 3e4;
  information(0, 4) = information(4, 0) = 5e4;
  CHECK(normalized_error_squared(exp_se3(xi) * estimated, estimated, information) ==
        doctest::Approx(xi.dot(information * xi)).epsilon(1e-6));
}

TEST_CASE("coverage: 95 of 100 errors drawn from the reported covariance lie inside, fewer when it is too small") {
  std::mt19937 generator(8);
  std::normal_distribution<double> normal;
  Matrix6 root = Matrix6::Zero();  // of the covariance: correlated, units mixed
  root.diagonal() << 1e-3, 2e-3, 5e-3, 3e-3, 1e-3, 4e-3;
  root(2, 0) = 2e-3;
  root(5, 1) = -3e-3;
  const Matrix6 information = (root * root.transpose()).inverse();
  std::vector<FrameRecord> records;
  for (int i = 0; i < 20000; ++i) {
    Twist xi;
    for (int k = 0; k < 6; ++k) {
      xi[k] = normal(generator);
    }
    FrameRecord record;
    record.frame = i;
    record.result.status = Status::held;
    record.result.T_camera_object = random_pose(generator, 0.5, 1.0);
    record.result.information = information;
    record.T_camera_object_true = exp_se3(root * xi) * record.result.T_camera_object;
    record.error = pose_error(record.T_camera_object_true, record.result.T_camera_object);
    records.push_back(record);
  }
  // The share's own standard deviation is sqrt(0.95 0.05 / 20000) = 0.0015.
  Coverage coverage = summarize(records, kRbotFailure).coverage;
  CHECK(coverage.frames == 20000);
  CHECK(std::abs(coverage.inside_95 - 0.95) < 0.006);
  CHECK(coverage.median_squared == doctest::Approx(kChiSquared6Median).epsilon(0.03));

  // Standard deviations reported at half their size: P(chi2_6 < 12.59 / 4) = 0.2099.
  for (FrameRecord& record : records) {
    record.result.information = 4 * information;
  }
  coverage = summarize(records, kRbotFailure).coverage;
  CHECK(std::abs(coverage.inside_95 - 0.2099) < 0.012);

  // Frames reported lost, not counted, or without a covariance say nothing about it.
  records.resize(4);
  records[0].result.status = Status::lost;
  records[1].counted = false;
  records[2].result.information.setZero();
  CHECK(summarize(records, kRbotFailure).coverage.frames == 1);
}
