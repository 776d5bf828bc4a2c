#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "init/check_picture.hpp"
#include "init/click_session.hpp"
#include "init/point_pairs.hpp"
#include "init/point_residuals.hpp"
#include "init/pose_from_points.hpp"
#include "init/refine_on_frame.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"

using namespace holdfast;
using namespace holdfast::app;
using holdfast::test::CaughtError;
using holdfast::test::error_of;
using holdfast::test::TemporaryFolder;

#define CHECK_ERROR(action, code, ...)                    \
  do {                                                    \
    const CaughtError caught = error_of([&] { action; }); \
    CAPTURE(caught.message);                              \
    CHECK(caught.says(code, {__VA_ARGS__}));              \
  } while (false)

namespace {

const Camera kCamera{640, 480, 655, 660, 322, 236, {}};

std::vector<Eigen::Vector3d> box_corners() {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back(i & 1 ? 0.0945 : -0.0945, i & 2 ? 0.129 : -0.129, i & 4 ? 0.0375 : -0.0375);
  }
  return corners;
}

std::vector<PointPair> seen(const std::vector<Eigen::Vector3d>& points, const Camera& camera,
                            const Pose& T_camera_object) {
  std::vector<PointPair> pairs;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector2d ideal = camera.project(T_camera_object * point);
    pairs.push_back({point, camera.distort(ideal), "line " + std::to_string(pairs.size() + 1)});
  }
  return pairs;
}

Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                      .normalized()
                      .toRotationMatrix();
  const double distance = 0.6 + 0.3 * uniform(random);
  pose.translation() << 0.1 * uniform(random), 0.1 * uniform(random), distance;
  return pose;
}

double angle_between(const Pose& a, const Pose& b) { return rotation_angle(a.linear().transpose() * b.linear()); }

}  // namespace

TEST_CASE("Point pairs: columns, comments, headings, units") {
  const TemporaryFolder folder;
  const auto pairs = load_point_pairs(
      folder.write("p.csv", "# box\nx,y,z,u,v\n1,2,3,4.5,5.5\r\n\n -1; 2e1; +3; 4; 5 # last\n1 2 3 4 5\n"), 0.001);
  REQUIRE(pairs.size() == 3);
  CHECK(pairs[0].p_object.isApprox(Eigen::Vector3d(0.001, 0.002, 0.003)));
  CHECK(pairs[0].pixel == Eigen::Vector2d(4.5, 5.5));
  CHECK(pairs[0].name == "line 3");
  CHECK(pairs[1].p_object.isApprox(Eigen::Vector3d(-0.001, 0.02, 0.003)));

  save_point_pairs(folder / "saved.csv", pairs);
  const auto read = load_point_pairs(folder / "saved.csv", 1);
  REQUIRE(read.size() == 3);
  CHECK(read[1].p_object.isApprox(pairs[1].p_object));
  CHECK(read[1].pixel == pairs[1].pixel);
}

TEST_CASE("Point pairs that cannot be used: one line that names file, line and fault") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { load_point_pairs(folder.write("p.csv", text), 1); };
  CHECK_ERROR(load_point_pairs(folder / "none.csv", 1), ErrorCode::file, "none.csv", "do not exist");
  CHECK_ERROR(load("1,2,3,4\n"), ErrorCode::pose, "p.csv", "line 1", "4 columns", "x,y,z,u,v");
  CHECK_ERROR(load("0,0,0,1,1\n\n1,2,3,4,5,6\n"), ErrorCode::pose, "line 3", "6 columns");
  CHECK_ERROR(load("0,0,0,1,1\n1,2,3,4,\n"), ErrorCode::pose, "line 2", "'' is not a number");
  CHECK_ERROR(load("0,0,0,1,1\n1,2,three,4,5\n"), ErrorCode::pose, "line 2", "'three' is not a number");
  CHECK_ERROR(load("0,0,0,nan,1\n"), ErrorCode::pose, "line 1", "not finite");
  CHECK_ERROR(load("x,y,z,u,v\nx,y,z,u,v\n"), ErrorCode::pose, "line 2", "'x' is not a number");
  CHECK_ERROR(save_point_pairs(folder / "no/such.csv", {}), ErrorCode::output, "cannot write");
}

TEST_CASE("A pose from exact points is exact: corners of a box, of a plane, four or eight, with distortion") {
  std::mt19937 random(1);
  Camera distorted = kCamera;
  distorted.distortion = {-0.2, 0.08, 0.001, -0.0005, 0.01, 0, 0, 0};
  const std::vector<Eigen::Vector3d> corners = box_corners();
  const std::vector<std::vector<Eigen::Vector3d>> selections{
      corners,
      {corners[0], corners[1], corners[2], corners[4], corners[7]},
      {corners[0], corners[3], corners[5], corners[6]},  // a tetrahedron
      {corners[0], corners[1], corners[2], corners[3]},  // a rectangle
  };
  for (int trial = 0; trial < 25; ++trial) {
    const Pose expected = random_pose(random);
    for (const auto& points : selections) {
      for (const Camera& camera : {kCamera, distorted}) {
        CAPTURE(trial);
        CAPTURE(points.size());
        const PoseFromPoints result = pose_from_points(seen(points, camera, expected), camera);
        CHECK(result.rms < 1e-6);
        CHECK((result.T_camera_object.translation() - expected.translation()).norm() < 1e-6);
        CHECK(angle_between(result.T_camera_object, expected) < 1e-6);
      }
    }
  }
}

TEST_CASE("Noisy points give a pose as good as the noise allows") {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 1);
  int ambiguous = 0;
  for (int trial = 0; trial < 25; ++trial) {
    const Pose expected = random_pose(random);
    std::vector<PointPair> pairs = seen(box_corners(), kCamera, expected);
    for (PointPair& pair : pairs) {
      pair.pixel += Eigen::Vector2d(noise(random), noise(random));
    }
    const PoseFromPoints result = pose_from_points(pairs, kCamera);
    // 16 numbers, 6 parameters: expected sqrt(2 * 10 / 16) = 1.1 px; three times that is far beyond chance.
    CHECK(result.rms < 3.4);
    // At least squares no other pose fits better, the true one included.
    CHECK(result.rms <= root_mean_square(point_residuals(pairs, kCamera, expected)));
    CHECK(angle_between(result.T_camera_object, expected) < 0.08);
    ambiguous += result.warnings.empty() ? 0 : 1;
  }
  CHECK(ambiguous == 0);
}

TEST_CASE("Pose and focal length from exact points are exact") {
  std::mt19937 random(3);
  for (const double focal : {300.0, 660.0, 1500.0}) {
    const Camera camera{640, 480, focal, focal, 319.5, 239.5, {}};
    for (int trial = 0; trial < 5; ++trial) {
      Pose expected = random_pose(random);
      expected.translation().z() = 0.45 * std::max(1.0, focal / 660);  // near enough for perspective to show
      CAPTURE(focal);
      CAPTURE(trial);
      const PoseFromPoints result = pose_and_focal_from_points(seen(box_corners(), camera, expected), 640, 480);
      CHECK(result.camera.fx == doctest::Approx(focal).epsilon(1e-5));
      CHECK(result.camera.fx == result.camera.fy);
      CHECK(result.camera.cx == 319.5);
      CHECK(result.camera.width == 640);
      CHECK((result.T_camera_object.translation() - expected.translation()).norm() < 1e-4);
    }
  }
}

TEST_CASE("The real box: six hand-marked corners of a video frame") {
  const auto pairs = load_point_pairs(HOLDFAST_SOURCE_DIR "/apps/demo/box_corners_frame0.csv", 1);
  REQUIRE(pairs.size() == 6);
  // Known beforehand, found by other means: f = 660 px and centre (320, 240) fit to 2.1 px RMS.
  const PoseFromPoints known = pose_from_points(pairs, Camera{640, 480, 660, 660, 320, 240, {}});
  CHECK(known.rms == doctest::Approx(2.1).epsilon(0.03));
  const PoseFromPoints found = pose_and_focal_from_points(pairs, 640, 480);
  CAPTURE(found.camera.fx);
  CAPTURE(found.focal_sigma);
  CHECK(found.rms <= known.rms + 0.02);
  CHECK(std::abs(found.camera.fx - 660) < 2 * found.focal_sigma);
  MESSAGE("focal length " << found.camera.fx << " +- " << found.focal_sigma << " px, rms " << found.rms << " px");
}

TEST_CASE("Points that do not determine a pose are refused in one line") {
  std::mt19937 random(4);
  const Pose pose = random_pose(random);
  const auto error = [&pose](const std::vector<Eigen::Vector3d>& points) {
    return error_of([&] { pose_from_points(seen(points, kCamera, pose), kCamera); });
  };
  const auto line = [](double share) -> Eigen::Vector3d { return 0.1 * Eigen::Vector3d(share, 2 * share, -share); };
  CHECK(error({line(0), line(1), line(2), line(3), line(4)}).says(ErrorCode::pose, {"one line"}));
  CHECK(error({line(0), line(1), box_corners()[2]}).says(ErrorCode::pose, {"3 different points", "4 or more"}));
  CHECK(error({line(0), line(0), line(0), line(0)}).says(ErrorCode::pose, {"1 different points"}));
  CHECK(error({}).says(ErrorCode::pose, {"0 different points"}));

  std::vector<PointPair> same_pixel = seen(box_corners(), kCamera, pose);
  for (PointPair& pair : same_pixel) {
    pair.pixel = {320, 240};
  }
  CHECK_ERROR(pose_from_points(same_pixel, kCamera), ErrorCode::pose, "point pairs");

  std::vector<PointPair> five = seen(box_corners(), kCamera, pose);
  five.resize(5);
  CHECK_ERROR(pose_and_focal_from_points(five, 640, 480), ErrorCode::pose, "5 different points", "6 or more");

  // A plane seen face on: distance and focal length cannot be told apart.
  Pose face_on = Pose::Identity();
  face_on.translation().z() = 0.6;
  std::vector<Eigen::Vector3d> grid;
  for (int i = 0; i < 6; ++i) {
    grid.emplace_back(0.05 * (i % 3), 0.07 * (i / 3), 0);
  }
  CHECK_ERROR(pose_and_focal_from_points(seen(grid, kCamera, face_on), 640, 480), ErrorCode::pose, "focal length");
}

TEST_CASE("The deviation of a pose from points is that of its error") {
  std::mt19937 random(6);
  std::normal_distribution<double> click(0, 2);
  double position = 0, rotation = 0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Pose pose = random_pose(random);
    std::vector<PointPair> pairs = seen(box_corners(), kCamera, pose);  // whose middle is the origin
    for (PointPair& pair : pairs) pair.pixel += Eigen::Vector2d(click(random), click(random));
    const PoseFromPoints found = pose_from_points(pairs, kCamera);
    const Pose off = found.T_camera_object * pose.inverse();
    position += (found.T_camera_object.translation() - pose.translation()).squaredNorm() /
                (found.position_sigma * found.position_sigma);
    rotation += std::pow(Eigen::AngleAxisd(off.linear()).angle() / found.rotation_sigma, 2);
  }
  CHECK(position / kTrials == doctest::Approx(1).epsilon(0.6));
  CHECK(rotation / kTrials == doctest::Approx(1).epsilon(0.6));
}

TEST_CASE("Mistaken pairs and ambiguous views are said") {
  std::mt19937 random(5);
  Pose pose = random_pose(random);
  std::vector<PointPair> pairs = seen(box_corners(), kCamera, pose);
  std::swap(pairs[2].pixel, pairs[5].pixel);
  std::vector<PointPair> few(pairs.begin(), pairs.begin() + 5);
  const PoseFromPoints unclear = pose_from_points(few, kCamera);
  REQUIRE(unclear.warnings.size() >= 1);
  CHECK(unclear.warnings.back().find("do not belong together") != std::string::npos);
  CHECK(unclear.pairs.size() == 5);

  const PoseFromPoints swapped = pose_from_points(pairs, kCamera);
  REQUIRE(swapped.warnings.size() == 1);
  CHECK(swapped.warnings[0].starts_with("left out: the point of line 3 and line 6"));
  CHECK(swapped.pairs.size() == 6);
  CHECK(swapped.rms < 1e-6);
  CHECK((swapped.T_camera_object.inverse() * pose).matrix().isIdentity(1e-8));

  // The pose gives way to one of two mistaken points.
  pairs = seen(box_corners(), kCamera, pose);
  pairs[2].pixel.x() += 40;
  pairs[5].pixel.y() += 8;
  const PoseFromPoints two = pose_from_points(pairs, kCamera);
  REQUIRE(two.warnings.size() == 2);
  CHECK(two.warnings[0].starts_with("left out: the point of line 3"));
  CHECK(two.warnings[1].starts_with("the point of line 6 is still"));

  const Camera centred{640, 480, 650, 650, 319.5, 239.5, {}};
  std::vector<Eigen::Vector3d> points = box_corners();
  points.insert(points.end(), {{0.02, 0.01, 0.03}, {-0.03, 0.02, -0.01}});
  pairs = seen(points, centred, pose);
  pairs[4].pixel += Eigen::Vector2d(60, -25);
  const PoseFromPoints uncalibrated = pose_and_focal_from_points(pairs, centred.width, centred.height);
  REQUIRE(uncalibrated.warnings.size() >= 1);
  CHECK(uncalibrated.warnings[0].starts_with("left out: the point of line 5"));
  CHECK(uncalibrated.camera.fx == doctest::Approx(650).epsilon(1e-4));

  // A small square far away and nearly face on has two poses that no click tells apart.
  std::vector<Eigen::Vector3d> square{{0, 0, 0}, {0.05, 0, 0}, {0.05, 0.05, 0}, {0, 0.05, 0}};
  pose.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  pose.translation() << 0, 0, 1.5;
  const PoseFromPoints ambiguous = pose_from_points(seen(square, kCamera, pose), kCamera);
  REQUIRE(ambiguous.warnings.size() == 1);
  CHECK(ambiguous.warnings[0].find("another pose") != std::string::npos);
}

namespace {

Mesh box_mesh() {
  Mesh mesh;
  for (const Eigen::Vector3d& corner : box_corners()) {
    mesh.positions.push_back(corner.cast<float>());
  }
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}, {0, 4, 1}, {1, 4, 5},
                    {2, 3, 6}, {3, 7, 6}, {0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7}};
  return mesh;
}

Mesh sphere_mesh(int rings) {
  Mesh mesh;
  for (int ring = 0; ring <= rings; ++ring) {
    for (int i = 0; i < 2 * rings; ++i) {
      const double polar = M_PI * ring / rings;
      const double azimuth = M_PI * i / rings;
      mesh.positions.push_back((0.05 * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                       std::sin(polar) * std::sin(azimuth), std::cos(polar)))
                                   .cast<float>());
    }
  }
  const auto index = [rings](int ring, int i) {
    return static_cast<std::uint32_t>(2 * rings * ring + i % (2 * rings));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < 2 * rings; ++i) {
      mesh.triangles.push_back({index(ring, i), index(ring + 1, i), index(ring, i + 1)});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("Vertices to click: all of a box, seams once, a few far apart of a dense model") {
  Mesh box = box_mesh();
  box.positions.insert(box.positions.end(), box.positions.begin(), box.positions.end());
  CHECK(vertices_to_click(box).size() == 8);

  const std::vector<Eigen::Vector3d> spread = vertices_to_click(sphere_mesh(20));
  CHECK(spread.size() >= 8);
  CHECK(spread.size() <= 24);
  for (std::size_t i = 0; i < spread.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      CHECK((spread[i] - spread[j]).norm() > 0.03);  // of a sphere of radius 0.05
    }
  }
}

TEST_CASE("A click session turns clicks into the pairs of the vertices it asked for") {
  std::mt19937 random(6);
  const Pose expected = random_pose(random);
  const Mesh mesh = box_mesh();
  const cv::Mat frame(480, 640, CV_8UC3, cv::Scalar(60, 60, 60));
  ClickSession session(frame, mesh, kCamera);
  const EnlargedFrame enlarged(frame);
  CHECK(enlarged.factor() == 2);
  const std::vector<Eigen::Vector3d> vertices = vertices_to_click(mesh);
  const auto place_of = [&](std::size_t i) { return enlarged.to_picture(kCamera.project(expected * vertices[i])); };

  CHECK(session.pairs().empty());
  session.back();  // nothing to go back to
  session.click(place_of(0));
  session.click({1, 1});  // a slip
  session.back();
  session.click(place_of(1));
  session.skip();
  for (std::size_t i = 3; i < 7; ++i) {
    session.click(place_of(i));
  }
  const cv::Mat before_last = session.picture();
  CHECK_FALSE(session.all_asked());
  session.click(place_of(7));
  CHECK(session.all_asked());
  session.click({5, 5});  // nothing is asked for any more
  const std::vector<PointPair> pairs = session.pairs();
  REQUIRE(pairs.size() == 7);
  CHECK(pairs[2].name == "vertex 4");
  CHECK((pairs[2].pixel - kCamera.project(expected * vertices[3])).norm() < 1e-9);
  CHECK(angle_between(pose_from_points(pairs, kCamera).T_camera_object, expected) < 1e-6);
  CHECK(cv::norm(before_last, session.picture()) > 0);

  const cv::Mat before_turn = session.picture();
  session.turn_model(0.5, 0);
  CHECK(cv::norm(before_turn, session.picture()) > 0);
}

TEST_CASE("Clicking without a display is refused in one line") {
  unsetenv("WAYLAND_DISPLAY");
  unsetenv("DISPLAY");
  CHECK_ERROR(require_display(), ErrorCode::invalid_argument, "--click needs a display", "--points");
  setenv("DISPLAY", ":9753", 1);
  CHECK_ERROR(require_display(), ErrorCode::invalid_argument, "--click needs a display", "does not answer");
  unsetenv("DISPLAY");
}

TEST_CASE("The enlarged frame keeps pixel centres") {
  cv::Mat frame(60, 80, CV_8UC3, cv::Scalar(0, 0, 0));
  frame.at<cv::Vec3b>(20, 30) = {255, 255, 255};
  EnlargedFrame enlarged(frame);
  CHECK(enlarged.factor() == 16);
  cv::Mat grey;
  cv::cvtColor(enlarged.picture(), grey, cv::COLOR_BGR2GRAY);
  const cv::Moments moments = cv::moments(grey);
  const Eigen::Vector2d place = enlarged.to_picture({30, 20});
  CHECK(moments.m10 / moments.m00 == doctest::Approx(place.x()).epsilon(1e-3));
  CHECK(moments.m01 / moments.m00 == doctest::Approx(place.y()).epsilon(1e-3));
  CHECK((enlarged.to_frame(place) - Eigen::Vector2d(30, 20)).norm() < 1e-12);
}

TEST_CASE("The check picture shows the contour where the object is, bent by the lens") {
  Camera bent = kCamera;
  bent.distortion[0] = -0.3;
  const cv::Mat frame(480, 640, CV_8UC3, cv::Scalar(0, 0, 0));
  const Line line{{20, 20}, {600, 20}};
  const cv::Mat picture = check_picture(frame, bent, Pose::Identity(), {line}, {});
  const EnlargedFrame enlarged(frame);
  for (const double x : {100.0, 320.0, 500.0}) {
    const Eigen::Vector2d place = enlarged.to_picture(bent.distort({x, 20}));
    const cv::Vec3b color =
        picture.at<cv::Vec3b>(static_cast<int>(std::lround(place.y())), static_cast<int>(std::lround(place.x())));
    CHECK(color[1] > 100);
  }
  CHECK_ERROR(save_picture("/no/such/folder/p.png", picture), ErrorCode::output, "p.png", "folder");
  CHECK_ERROR(save_picture("p.nothing", picture), ErrorCode::output, "p.nothing", ".png");
}

TEST_CASE("A pose from points a few pixels off is refined on the frame; a frame without the object leaves it alone") {
  const Mesh mesh = simulation::textured_box();
  simulation::SequenceOptions options;
  options.frames = 1;
  options.seed = 5;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  const simulation::Sequence sequence(mesh, options);
  const simulation::SimulatedFrame frame = sequence.make(0);
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector3d& vertex : vertices_to_click(mesh)) {
    corners.push_back(vertex);
  }
  REQUIRE(corners.size() == 8);
  std::vector<PointPair> pairs = seen(corners, options.camera, frame.T_camera_object);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1.5);
  for (PointPair& pair : pairs) {
    pair.pixel += Eigen::Vector2d(noise(random), noise(random));
  }
  const PoseFromPoints from_points = pose_from_points(pairs, options.camera);
  const auto error = [&frame](const Pose& pose) {
    return (pose.translation() - frame.T_camera_object.translation()).norm();
  };
  REQUIRE(error(from_points.T_camera_object) > 2e-3);  // else there is nothing to refine

  const Device device;
  const RefinementOnFrame refined =
      refine_on_frame(mesh, options.camera, device, frame.image, pairs, from_points.T_camera_object);
  CAPTURE(refined.reason);
  CHECK(refined.accepted);
  CHECK(error(refined.T_camera_object) < 1e-3);
  CHECK(angle_between(refined.T_camera_object, frame.T_camera_object) < 0.005);
  CHECK(refined.correlation > 0.8);

  const cv::Mat empty(options.camera.height, options.camera.width, CV_8UC3, cv::Scalar(90, 90, 90));
  const RefinementOnFrame lost =
      refine_on_frame(mesh, options.camera, device, empty, pairs, from_points.T_camera_object);
  CHECK_FALSE(lost.accepted);
  CHECK_FALSE(lost.reason.empty());
  CHECK(lost.T_camera_object.isApprox(from_points.T_camera_object, 0));

  // The object is seen, but not where the points say.
  for (PointPair& pair : pairs) {
    pair.pixel.x() += 12;
  }
  const PoseFromPoints elsewhere = pose_from_points(pairs, options.camera);
  const RefinementOnFrame disagreeing =
      refine_on_frame(mesh, options.camera, device, frame.image, pairs, elsewhere.T_camera_object);
  CHECK_FALSE(disagreeing.accepted);
  CHECK_FALSE(disagreeing.reason.empty());
}
