#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <future>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "simulation/sequence.hpp"
#include "simulation/sequence_files.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"

namespace holdfast::simulation {
namespace {

using test::error_of;
using test::TemporaryFolder;

const Camera test_camera = {320, 240, 400, 380, 163.2, 117.4, {}};

double linear(double grey) { return linear_from_encoded(grey / 255.0); }

// A still picture of one grey level to put behind things.
std::filesystem::path plain_background(const TemporaryFolder& folder, int grey) {
  const std::filesystem::path path = folder / "background.png";
  cv::imwrite(path.string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(grey)));
  return path;
}

// OpenCV's camera model: independent of the simulator's.
std::vector<cv::Point2d> project(const std::vector<Eigen::Vector3d>& points, const Pose& pose, const Camera& camera) {
  std::vector<cv::Point3d> p_camera;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d moved = pose * p;
    p_camera.emplace_back(moved.x(), moved.y(), moved.z());
  }
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(p_camera, cv::Vec3d(), cv::Vec3d(), matrix, distortion, pixels);
  return pixels;
}

std::vector<Eigen::Vector3d> corners_of(const Mesh& mesh) {
  const auto corners = bounding_corners(mesh);
  return {corners.begin(), corners.end()};
}

// Pixels of a box's edges, closely spaced: the silhouette's outline is among them however the lens bends it.
std::vector<cv::Point2d> edge_pixels(const Mesh& box, const Pose& pose, const Camera& camera) {
  const auto corners = bounding_corners(box);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < 8; ++i) {
    for (const std::size_t bit : {1, 2, 4}) {
      if (i & bit) continue;
      for (int k = 0; k <= 400; ++k) points.push_back(corners[i] + k / 400.0 * (corners[i | bit] - corners[i]));
    }
  }
  return project(points, pose, camera);
}

struct Span {
  double left, right;
};

// Where row y meets the outermost of the edges.
Span outline_at(const std::vector<cv::Point2d>& edges, double y) {
  Span span{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    if (i % 401 == 400) continue;  // from one edge to the next
    const cv::Point2d &a = edges[i], &b = edges[i + 1];
    if ((a.y - y) * (b.y - y) > 0 || a.y == b.y) continue;
    const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    span.left = std::min(span.left, x);
    span.right = std::max(span.right, x);
  }
  return span;
}

// Where the light of a row begins and ends, by the area under it to either side of a column inside.
Span measured_span(const cv::Mat& image, int y, double white) {
  int middle = 0;
  double total = 0, moment = 0;
  for (int x = 0; x < image.cols; ++x) {
    const double share = linear(image.at<cv::Vec3b>(y, x)[1]) / white;
    total += share;
    moment += share * x;
  }
  middle = static_cast<int>(moment / total);
  Span span{middle + 0.5, middle + 0.5};
  for (int x = 0; x < image.cols; ++x) {
    const double share = linear(image.at<cv::Vec3b>(y, x)[1]) / white;
    (x <= middle ? span.left : span.right) += x <= middle ? -share : share;
  }
  return span;
}

SequenceOptions still_options(const TemporaryFolder& folder, const Camera& camera, const Pose& pose) {
  SequenceOptions options;
  options.camera = camera;
  options.frames = 1;
  options.samples = 8;
  options.motion.T_camera_object = {pose};
  options.lighting = LightingOptions::flat();
  options.background.file = plain_background(folder, 0);
  return options;
}

void check_outline(const Camera& camera) {
  const TemporaryFolder folder;
  const Mesh box = plain_box({0.2, 0.15, 0.08}, {255, 255, 255});
  Pose pose = Pose::Identity();
  pose.linear() = MotionOptions::default_orientation();
  pose.translation() = Eigen::Vector3d(0.05, -0.02, 0.6);
  const Sequence sequence(box, still_options(folder, camera, pose));
  const cv::Mat image = sequence.frame(0);
  const std::vector<cv::Point2d> edges = edge_pixels(box, pose, camera);
  std::vector<double> corner_rows;
  for (const cv::Point2d& p : project(corners_of(box), pose, camera)) corner_rows.push_back(p.y);
  const double top = *std::min_element(corner_rows.begin(), corner_rows.end());
  const double bottom = *std::max_element(corner_rows.begin(), corner_rows.end());
  REQUIRE(bottom - top > 80);
  int rows = 0;
  double error_sum = 0;
  for (int y = static_cast<int>(top) + 3; y < bottom - 3; ++y) {
    // Within a row that holds a corner the outline is not straight.
    if (std::any_of(corner_rows.begin(), corner_rows.end(), [y](double row) { return std::abs(row - y) < 1; }))
      continue;
    const Span expected = outline_at(edges, y);
    const Span measured = measured_span(image, y, 1.0);
    // Eight samples a pixel: an edge that runs along their columns is known to half their spacing.
    CHECK(std::abs(measured.left - expected.left) < 1.0 / 16 + 0.02);
    CHECK(std::abs(measured.right - expected.right) < 1.0 / 16 + 0.02);
    error_sum += measured.left - expected.left + measured.right - expected.right;
    ++rows;
  }
  REQUIRE(rows > 60);
  CHECK(std::abs(error_sum / (2 * rows)) < 0.01);
}

TEST_CASE("The object's outline is where pose and camera say, to a few hundredths of a pixel") {
  check_outline(test_camera);
}

TEST_CASE("A distorting lens bends the outline as OpenCV's model says") {
  Camera camera = test_camera;
  camera.distortion = {-0.25, 0.08, 0.002, -0.001, 0, 0, 0, 0};
  check_outline(camera);
  camera.distortion = {0.2, 0.1, -0.001, 0.002, 0.05, 0.1, 0.05, 0.01};
  check_outline(camera);
}

TEST_CASE("A lens that folds the picture over is refused") {
  SequenceOptions options;
  options.camera.distortion = {-3.0, 0, 0, 0, 0, 0, 0, 0};
  const auto error = error_of([&] { Sequence(textured_box(), options); });
  CHECK(error.says(ErrorCode::camera, {"distortion", "pixel"}));
}

TEST_CASE("A texture lies on its surface where its coordinates say") {
  // A quad of 1000 texels of which the first 417 are black, seen at 0.31 pixels a texel.
  Mesh quad;
  quad.positions = {{-0.5F, -0.2F, 0}, {0.5F, -0.2F, 0}, {0.5F, 0.2F, 0}, {-0.5F, 0.2F, 0}};
  quad.texture_coordinates = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  quad.triangles = {{0, 1, 2}, {0, 2, 3}};
  Material material;
  material.texture.width = 1000;
  material.texture.height = 4;
  for (int i = 0; i < 4000; ++i) {
    const std::uint8_t value = i % 1000 < 417 ? 0 : 255;
    for (const std::uint8_t byte : {value, value, value, std::uint8_t{255}}) material.texture.rgba.push_back(byte);
  }
  quad.materials.push_back(material);

  const TemporaryFolder folder;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  pose.translation().z() = 400 / 310.0;
  const Sequence sequence(quad, still_options(folder, test_camera, pose));
  const cv::Mat image = sequence.frame(0);
  const double expected = test_camera.cx + 400 * (0.417 - 0.5) / pose.translation().z();
  for (const int y : {90, 117, 140})
    CHECK(measured_span(image, y, 1.0).left == doctest::Approx(expected).epsilon(0.0002));
}

TEST_CASE("Textures keep their mean however small they are seen") {
  const Mesh box = textured_box();
  const Texture& texture = box.materials[0].texture;
  // The front's place in the texture.
  Eigen::Vector2f low = box.texture_coordinates[0], high = low;
  for (std::size_t i = 0; i < 4; ++i) {
    low = low.cwiseMin(box.texture_coordinates[i]);
    high = high.cwiseMax(box.texture_coordinates[i]);
  }
  double sum = 0;
  int count = 0;
  for (int y = cvRound((1 - high.y()) * static_cast<float>(texture.height));
       y < cvRound((1 - low.y()) * static_cast<float>(texture.height)); ++y) {
    for (int x = cvRound(low.x() * static_cast<float>(texture.width));
         x < cvRound(high.x() * static_cast<float>(texture.width)); ++x, ++count) {
      sum += linear(texture.rgba[4 * (static_cast<std::size_t>(y) * texture.width + x) + 1]);
    }
  }
  const DrawnMesh mesh(box);
  for (const double distance : {0.5, 1.0, 4.0}) {
    Scene scene;
    scene.ambient.setOnes();
    scene.object.mesh = &mesh;
    scene.object.T_camera_object.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    scene.object.T_camera_object.translation().z() = distance;
    Camera camera = test_camera;
    camera.fx = camera.fy = 250;
    const Layer layer = draw(scene, camera, 3);
    CHECK(cv::sum(layer.light)[1] / cv::sum(layer.object_share)[0] == doctest::Approx(sum / count).epsilon(0.02));
  }
}

TEST_CASE("Surfaces are lit by Lambert's law, and highlights are where the mirror direction is") {
  const DrawnMesh mesh(plain_box({0.2, 0.2, 0.02}, {255, 255, 255}));
  Scene scene;
  scene.object.mesh = &mesh;
  scene.object.T_camera_object.translation().z() = 1;
  scene.ambient.setConstant(0.25F);
  PointLight lamp;
  lamp.position = 1000 * Eigen::Vector3d(std::sqrt(0.75), 0, -0.5);  // 60 degrees off the front's normal
  lamp.color.setConstant(0.6F);
  scene.lights = {lamp};
  Camera camera = test_camera;
  camera.cx = 160;
  camera.cy = 120;
  const auto middle = [&] {
    const Layer layer = draw(scene, camera, 2);
    return static_cast<double>(layer.light.at<cv::Vec3f>(120 - layer.region.y, 160 - layer.region.x)[0]);
  };
  CHECK(middle() == doctest::Approx(0.25 + 0.5 * 0.6).epsilon(0.005));
  scene.object.finish.specular = 0.5;
  CHECK(middle() == doctest::Approx(0.25 + 0.5 * 0.6).epsilon(0.01));  // no mirror image of that lamp from here
  scene.lights[0].position = Eigen::Vector3d(0, 0, -1000);
  CHECK(middle() == doctest::Approx(0.25 + 0.6 + 0.5 * 0.6).epsilon(0.01));
}

// A box seen straight on, alone in the frame: its silhouette is its front.
struct FrontalBox {
  Mesh mesh = plain_box({0.2, 0.15, 0.08}, {200, 60, 60});
  Pose pose = Pose::Identity();
  double front_width;  // pixels
  FrontalBox() {
    pose.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    pose.translation().z() = 0.7;
    front_width = test_camera.fx * 0.2 / (0.7 - 0.04);
  }
};

TEST_CASE("A bar hides the share of the object that its width says") {
  const TemporaryFolder folder;
  const FrontalBox box;
  SequenceOptions options = still_options(folder, test_camera, box.pose);
  OccluderOptions bar;
  bar.sweeps = 0;
  bar.bar_column = test_camera.cx + 7;
  for (const double width : {12.0, 31.5, 80.0}) {
    bar.bar_width = width;
    options.occluders = {bar};
    const Sequence sequence(box.mesh, options);
    const SimulatedFrame frame = sequence.make(0);
    CHECK(frame.visible_share == doctest::Approx(1 - width / box.front_width).epsilon(0.005));
    CHECK(sequence.visible_share(0) == frame.visible_share);
    CHECK(cv::sum(frame.occluder_mask.row(120))[0] / 255 == doctest::Approx(width).epsilon(0.01));
    CHECK(frame.occluder_mask.at<std::uint8_t>(120, cvRound(bar.bar_column)) == 255);
    CHECK(frame.object_mask.at<std::uint8_t>(120, cvRound(bar.bar_column)) == 0);
  }
}

TEST_CASE("What is in front hides, what is behind does not") {
  const TemporaryFolder folder;
  const FrontalBox box;
  SequenceOptions options = still_options(folder, test_camera, box.pose);
  OccluderOptions wall;
  wall.kind = OccluderKind::mesh;
  wall.mesh = plain_box({0.6, 0.6, 0.01}, {20, 250, 20});
  const auto share_at = [&](double distance) {
    Pose pose = Pose::Identity();
    pose.translation().z() = distance;
    wall.T_camera_mesh = {pose};
    options.occluders = {wall};
    return Sequence(box.mesh, options).make(0);
  };
  CHECK(share_at(0.5).visible_share == 0);
  const SimulatedFrame behind = share_at(0.9);
  CHECK(behind.visible_share == 1);
  CHECK(behind.image.at<cv::Vec3b>(117, 163) == cv::Vec3b(60, 60, 200));
  CHECK(behind.image.at<cv::Vec3b>(117, 40) == cv::Vec3b(20, 250, 20));

  // A slanted wall that pierces the front along its middle hides one half.
  Pose slanted = Pose::Identity();
  slanted.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).toRotationMatrix();
  slanted.translation().z() = 0.66 + 0.005 / std::cos(0.6);
  wall.T_camera_mesh = {slanted};
  options.occluders = {wall};
  CHECK(Sequence(box.mesh, options).visible_share(0) == doctest::Approx(0.5).epsilon(0.01));
}

TEST_CASE("An object out of view has no visible share") {
  const TemporaryFolder folder;
  FrontalBox box;
  box.pose.translation().x() = 5;
  CHECK(Sequence(box.mesh, still_options(folder, test_camera, box.pose)).make(0).visible_share == 0);
}

// The fastest corner's motion from each frame to the next, by OpenCV's camera model.
std::vector<double> corner_speeds(const Sequence& sequence, const Mesh& mesh) {
  std::vector<double> speeds;
  std::vector<cv::Point2d> last;
  for (const Pose& pose : sequence.poses()) {
    const std::vector<cv::Point2d> pixels = project(corners_of(mesh), pose, sequence.camera());
    double fastest = 0;
    for (std::size_t i = 0; i < last.size(); ++i) fastest = std::max(fastest, cv::norm(pixels[i] - last[i]));
    if (!last.empty()) speeds.push_back(fastest);
    last = pixels;
  }
  return speeds;
}

TEST_CASE("Corners move as fast as asked for, and the object stays in view between the distances") {
  const Mesh box = textured_box();
  SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 300;
  options.motion.nearest = 0.6;
  options.motion.farthest = 1.2;
  for (const MotionStyle style : {MotionStyle::smooth, MotionStyle::sharp}) {
    for (const double speed : {1.5, 6.0, 12.0}) {
      for (const std::uint64_t seed : {1, 2, 3}) {
        CAPTURE(static_cast<int>(style));
        CAPTURE(speed);
        CAPTURE(seed);
        options.motion.style = style;
        options.motion.speed = speed;
        options.seed = seed;
        const Sequence sequence(box, options);
        const std::vector<double> speeds = corner_speeds(sequence, box);
        const auto share = [&](double low, double high) {
          return static_cast<double>(std::count_if(speeds.begin(), speeds.end(),
                                                   [&](double s) { return s > low * speed && s <= high * speed; })) /
                 static_cast<double>(speeds.size());
        };
        const MotionSummary summary = summarize_motion(sequence.poses(), box, options.camera);
        CHECK(summary.corner_speed.size() == speeds.size());
        CHECK(summary.max_speed == doctest::Approx(*std::max_element(speeds.begin(), speeds.end())));
        if (style == MotionStyle::smooth) {
          CHECK(share(0, 1.0001) == doctest::Approx(0.95).epsilon(0.01));
        } else {
          CHECK(share(0.97, 1.01) >= 0.93);
          CHECK(share(1.01, 100) == 0);
          CHECK(summary.turns >= options.motion.turns);
        }
        CHECK(summary.nearest > 0.6 * 0.999);
        CHECK(summary.farthest < 1.2 * 1.001);
        for (const Pose& pose : sequence.poses()) {
          int outside = 0;
          for (const cv::Point2d& p : project(corners_of(box), pose, options.camera)) {
            if (p.x < 0 || p.y < 0 || p.x > 511 || p.y > 255) ++outside;
          }
          CHECK(outside <= 4);
          CHECK(std::abs(pose.linear().determinant() - 1) < 1e-9);
        }
      }
    }
  }
}

TEST_CASE("Eased motion starts at rest, turns at rest, and gains speed evenly in between") {
  const Mesh box = textured_box();
  SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 300;
  options.motion.style = MotionStyle::sharp;
  options.motion.nearest = 0.6;
  options.motion.farthest = 1.2;
  options.motion.speed = 6;
  options.motion.ease = 10;
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    options.seed = seed;
    const Sequence sequence(box, options);
    const std::vector<double> speeds = corner_speeds(sequence, box);
    // Half an acceleration in the first frame; at most one more in each further one (a little more where the path's
    // pixels are counted along a curve).
    CHECK(speeds.front() == doctest::Approx(0.3).epsilon(0.05));
    for (std::size_t i = 1; i < speeds.size(); ++i) CHECK(std::abs(speeds[i] - speeds[i - 1]) < 0.65);
    CHECK(*std::max_element(speeds.begin(), speeds.end()) < 6.1);
    CHECK(std::count_if(speeds.begin(), speeds.end(), [](double s) { return s > 5.8; }) > 120);
    CHECK(summarize_motion(sequence.poses(), box, options.camera).turns >= options.motion.turns);
  }
  options.motion.ease = 60;
  CHECK_THROWS_AS(Sequence(box, options), Error);
}

TEST_CASE("Smooth motion has no corners: its acceleration is small beside its speed") {
  const Mesh box = textured_box();
  SequenceOptions options;
  options.motion.speed = 6;
  const Sequence sequence(box, options);
  const auto corners = corners_of(box);
  double largest = 0;
  for (int i = 1; i + 1 < sequence.size(); ++i) {
    const auto a = project(corners, sequence.pose(i - 1), sequence.camera());
    const auto b = project(corners, sequence.pose(i), sequence.camera());
    const auto c = project(corners, sequence.pose(i + 1), sequence.camera());
    for (std::size_t k = 0; k < 8; ++k) largest = std::max(largest, cv::norm(c[k] - 2 * b[k] + a[k]));
  }
  CHECK(largest < 1.5);  // pixels a frame squared; a sharp turn back at this speed has 12
}

TEST_CASE("Motion blur is centred on the frame's pose and as long as the exposure") {
  const TemporaryFolder folder;
  const Mesh stick = plain_box({0.03, 0.1, 0.001}, {255, 255, 255});
  SequenceOptions options = still_options(folder, test_camera, Pose::Identity());
  options.motion.T_camera_object.clear();
  options.frames = 3;
  constexpr double speed = 8.7;  // pixels a frame; no whole number, so that draws meet the samples evenly
  for (int i = 0; i < 3; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d((i - 1) * speed / test_camera.fx, 0, 1);
    options.motion.T_camera_object.push_back(pose);
  }
  struct Moments {
    double mean, variance;
  };
  const auto moments = [&](int frame) {
    const cv::Mat image = Sequence(stick, options).frame(frame);
    double sum = 0, first = 0, second = 0;
    for (int x = 0; x < image.cols; ++x) {
      const double light = linear(image.at<cv::Vec3b>(117, x)[0]);
      sum += light;
      first += light * x;
      second += light * x * x;
    }
    return Moments{first / sum, second / sum - std::pow(first / sum, 2)};
  };
  for (const int frame : {0, 1, 2}) {  // the first and last exposures reach beyond the given poses
    options.motion_blur = 0;
    const Moments sharp = moments(frame);
    const double column = test_camera.cx + (frame - 1) * speed;
    CHECK(std::abs(sharp.mean - column) < 1.0 / 16);  // half the spacing of samples
    for (const double exposure : {0.5, 1.0}) {
      options.motion_blur = exposure;
      const Moments blurred = moments(frame);
      CHECK(std::abs(blurred.mean - column) < 0.04);  // several draws average that
      // A uniform spread over the way moved adds its variance, of which five draws already show all but 4 %.
      CHECK(blurred.variance - sharp.variance == doctest::Approx(std::pow(speed * exposure, 2) / 12).epsilon(0.06));
    }
  }
}

SequenceOptions everything_on() {
  SequenceOptions options;
  options.camera = {160, 120, 180, 180, 79.5, 59.5, {}};
  options.frames = 6;
  options.samples = 2;
  options.motion_blur = 0.5;
  OccluderOptions cube;
  cube.kind = OccluderKind::cube;
  options.occluders = {OccluderOptions(), cube};
  options.lighting.finish.specular = 0.4;
  options.lighting.lights[0].orbit_radius = 0.3;
  options.background.pan = 2;
  options.sensor.noise = 2;
  options.sensor.shot_noise = 3;
  options.sensor.blur_sigma = 0.6;
  options.sensor.exposure_stops = 0.5;
  options.sensor.white_balance_stops = 0.2;
  options.sensor.gamma_stops = 0.1;
  options.sensor.jpeg_quality = 80;
  return options;
}

bool same(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0; }

TEST_CASE("Frames depend on the seed alone: not on order, instance or threads") {
  const Mesh box = textured_box();
  SequenceOptions options = everything_on();
  const Sequence sequence(box, options);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < sequence.size(); ++i) frames.push_back(sequence.frame(i));

  const Sequence again(textured_box(), options);
  for (int i = sequence.size() - 1; i >= 0; --i) CHECK(same(again.frame(i), frames[static_cast<std::size_t>(i)]));
  std::vector<std::future<cv::Mat>> parallel;
  for (int i = 0; i < sequence.size(); ++i)
    parallel.push_back(std::async(std::launch::async, [&, i] { return again.frame(i); }));
  for (int i = 0; i < sequence.size(); ++i)
    CHECK(same(parallel[static_cast<std::size_t>(i)].get(), frames[static_cast<std::size_t>(i)]));

  options.seed = 2;
  CHECK_FALSE(same(Sequence(box, options).frame(0), frames[0]));
  CHECK_FALSE(same(frames[0], frames[1]));
}

TEST_CASE("Noise is as strong as asked for and independent from frame to frame") {
  SensorOptions options;
  options.noise = 4;
  const cv::Mat grey(200, 300, CV_32FC3, cv::Scalar::all(linear(100)));
  const auto spread = [](const cv::Mat& image) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    return std::pair(mean[1], deviation[1]);
  };
  const Sensor even(options, 1);
  const auto [mean, deviation] = spread(even.record(grey, 0));
  CHECK(mean == doctest::Approx(100).epsilon(0.002));
  CHECK(deviation == doctest::Approx(std::sqrt(16 + 1.0 / 12)).epsilon(0.02));  // with the rounding to whole levels

  options.noise = 0;
  options.shot_noise = 6;
  const Sensor shot(options, 1);
  CHECK(spread(shot.record(grey, 0)).second == doctest::Approx(std::sqrt(36 * 100 / 255.0 + 1.0 / 12)).epsilon(0.02));

  cv::Mat first, second;
  even.record(grey, 0).convertTo(first, CV_64F, 1, -100);
  even.record(grey, 1).convertTo(second, CV_64F, 1, -100);
  CHECK(std::abs(cv::mean(first.mul(second))[1]) / 16 < 0.02);
  cv::Mat shifted = first(cv::Rect(1, 0, 299, 200)).mul(first(cv::Rect(0, 0, 299, 200)));
  CHECK(std::abs(cv::mean(shifted)[1]) / 16 < 0.02);
}

TEST_CASE("Exposure and white balance change the light by the stops asked for") {
  SensorOptions options;
  options.exposure_stops = 1;
  options.change_frames = 100;
  const cv::Mat grey(2, 2, CV_32FC3, cv::Scalar::all(0.2));
  const auto light = [&](int frame, int channel) {
    return linear(Sensor(options, 1).record(grey, frame).at<cv::Vec3b>(0, 0)[channel]);
  };
  CHECK(light(0, 1) == doctest::Approx(0.2).epsilon(0.02));
  CHECK(light(25, 1) == doctest::Approx(0.4).epsilon(0.02));
  CHECK(light(75, 1) == doctest::Approx(0.1).epsilon(0.02));
  options = {};
  options.white_balance_stops = 0.5;
  options.change_frames = 70;
  CHECK(light(25, 2) / light(25, 0) == doctest::Approx(2).epsilon(0.03));
  CHECK(light(25, 1) == doctest::Approx(0.2).epsilon(0.02));
}

TEST_CASE("The cube covers most of the object near the end, then leaves") {
  const Mesh box = textured_box();
  SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 300;
  options.motion.style = MotionStyle::sharp;
  options.motion.speed = 6;
  options.motion.nearest = 0.6;
  options.motion.farthest = 1.2;
  OccluderOptions cube;
  cube.kind = OccluderKind::cube;
  options.occluders = {cube};
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    options.seed = seed;
    const Sequence sequence(box, options);
    double least = 1;
    for (int i = 200; i < 260; i += 2) least = std::min(least, sequence.visible_share(i));
    CHECK(least < 0.15);
    for (int i = 260; i < 300; i += 3) CHECK(sequence.visible_share(i) == 1);
  }
}

TEST_CASE("Files are laid out as evaluation reads them, the same for any number of threads") {
  const Mesh box = textured_box();
  const SequenceOptions options = everything_on();
  const Sequence sequence(box, options);
  const TemporaryFolder folder;
  SequenceFileOptions files;
  files.masks = true;
  files.threads = 1;
  write_sequence(sequence, folder / "one", files);
  files.threads = 3;
  write_sequence(sequence, folder / "three", files);

  const std::vector<Pose> poses = io::load_poses(folder / "one/poses_gt.txt");
  REQUIRE(static_cast<int>(poses.size()) == sequence.size());
  for (int i = 0; i < sequence.size(); ++i) {
    CHECK((poses[static_cast<std::size_t>(i)].matrix() - sequence.pose(i).matrix()).cwiseAbs().maxCoeff() < 1e-8);
    const std::string name = "00000" + std::to_string(i);
    for (const std::string& file : {"frames/" + name + ".jpg", "masks/" + name + ".png"}) {
      CHECK(test::read_file(folder / ("one/" + file)) == test::read_file(folder / ("three/" + file)));
    }
    const SimulatedFrame frame = sequence.make(i);
    CHECK(same(cv::imread((folder / ("one/frames/" + name + ".jpg")).string()), frame.image));
    CHECK(same(cv::imread((folder / ("one/masks/" + name + ".png")).string(), cv::IMREAD_GRAYSCALE),
               frame.occluder_mask));
  }
  CHECK(test::read_file(folder / "one/visible.txt") == test::read_file(folder / "three/visible.txt"));
  const Camera camera = io::load_camera(folder / "one/K.txt");
  CHECK(camera.fx == options.camera.fx);
  CHECK(camera.cy == options.camera.cy);

  const auto again = error_of([&] { write_sequence(sequence, folder / "one", files); });
  CHECK(again.says(ErrorCode::output, {"holds a sequence already", "--overwrite"}));
  files.overwrite = true;
  SequenceOptions shorter = options;
  shorter.frames = 2;
  write_sequence(Sequence(box, shorter), folder / "one", files);
  CHECK(std::distance(std::filesystem::directory_iterator(folder / "one/frames"), {}) == 2);
}

TEST_CASE("A picture or a video lies behind the object") {
  const TemporaryFolder folder;
  BackgroundOptions options;
  options.file = plain_background(folder, 90);
  CHECK(Background(options, {64, 48}, 1).at(3).at<cv::Vec3f>(20, 20)[1] == doctest::Approx(linear(90)).epsilon(0.001));

  options.file = folder / "video.avi";
  cv::VideoWriter video(options.file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {64, 48});
  REQUIRE(video.isOpened());
  for (int i = 0; i < 4; ++i) video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(40 + 50 * i)));
  video.release();
  const Background moving(options, {64, 48}, 1);
  for (const int frame : {0, 3, 1, 2, 9, 4, 7}) {  // in any order, from the start again at the end
    CAPTURE(frame);
    const double light = moving.at(frame).at<cv::Vec3f>(20, 20)[1];
    CHECK(255 * encoded_from_linear(light) == doctest::Approx(40 + 50 * (frame % 4)).epsilon(0.03));
  }

  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  options.file = folder / "missing.png";
  CHECK(error_of([&] { Background(options, {64, 48}, 1); }).says(ErrorCode::file, {"missing.png", "no such"}));
  options.file = folder.write("broken.avi", "no video");
  CHECK(error_of([&] {
          Background(options, {64, 48}, 1);
        }).says(ErrorCode::file, {"broken.avi", "neither a picture nor a video"}));
}

TEST_CASE("Wrong options are named in one line") {
  const Mesh box = textured_box();
  const auto error_with = [&](auto&& change) {
    SequenceOptions options;
    options.frames = 20;
    change(options);
    return error_of([&] { Sequence(box, options); });
  };
  constexpr ErrorCode wrong = ErrorCode::invalid_argument;
  CHECK(error_with([](SequenceOptions& o) { o.frames = 0; }).says(wrong, {"at least one frame"}));
  CHECK(error_with([](SequenceOptions& o) { o.samples = 0; }).says(wrong, {"samples"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion_blur = 2; }).says(wrong, {"motion blur"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.speed = 0; }).says(wrong, {"speed"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.speed = 5000; }).says(wrong, {"cannot move that fast"}));
  CHECK(error_with([](SequenceOptions& o) {
          o.motion.style = MotionStyle::sharp;
          o.motion.turns = 19;
        }).says(wrong, {"19 turns", "20 frames"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.nearest = 0.05; }).says(wrong, {"nearest distance"}));
  CHECK(
      error_with([](SequenceOptions& o) { o.motion.nearest = 1, o.motion.farthest = 0.5; }).says(wrong, {"farthest"}));
  CHECK(error_with([](SequenceOptions& o) {
          o.motion.T_camera_object = {Pose::Identity()};
        }).says(wrong, {"fewer poses"}));
  CHECK(error_with([](SequenceOptions& o) { o.sensor.jpeg_quality = 101; }).says(wrong, {"JPEG"}));
  CHECK(error_with([](SequenceOptions& o) { o.sensor.noise = -1; }).says(wrong, {"noise"}));
  CHECK(error_of([&] { Sequence(box, SequenceOptions()).frame(1000); }).says(wrong, {"no frame 1000"}));
  CHECK(error_of([] { textured_box({.size = {0.1, 0, 0.1}}); }).says(wrong, {"sides"}));
  Mesh empty;
  CHECK(error_of([&] { Sequence(empty, SequenceOptions()); }).says(ErrorCode::model, {}));
}

}  // namespace
}  // namespace holdfast::simulation
