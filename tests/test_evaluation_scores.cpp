// The evaluation's scores against values worked out by hand and brute force.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "evaluation/model_points.hpp"
#include "evaluation/nearest_point.hpp"
#include "evaluation/pose_error.hpp"
#include "evaluation/statistics.hpp"
#include "evaluation/summary.hpp"
#include "support/evaluated.hpp"

using namespace holdfast;
using namespace holdfast::evaluation;
using namespace holdfast::test;

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

TEST_CASE("normalised error: the information matrix is about T_true = T_estimated exp(xi), object axes") {
  std::mt19937 generator(7);
  const Pose estimated = random_pose(generator, 0.4, 1.0);
  Twist xi;
  xi << 0.001, -0.002, 0.004, 0.01, 0.02, -0.005;
  Matrix6 information = Matrix6::Zero();
  information.diagonal() << 1e6, 2e6, 1e5, 1e4, 2e4, 3e4;
  information(0, 4) = information(4, 0) = 5e4;
  CHECK(normalized_error_squared(estimated * exp_se3(xi), estimated, information) ==
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
    record.T_camera_object_true = record.result.T_camera_object * exp_se3(root * xi);
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
