// Where the simulator puts things: outlines, textures, light and what hides what.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated_scene.hpp"

namespace holdfast::simulation {
namespace {

using namespace test;

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

// A box seen straight on, alone in the frame: its silhouette is its front.
struct FrontalBox {
  Mesh mesh = plain_box({0.2, 0.15, 0.08}, {200, 60, 60});
  Pose pose = Pose::Identity();
  double front_width;  // pixels
  FrontalBox() {
    pose.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    pose.translation().z() = 0.7;
    front_width = kSceneCamera.fx * 0.2 / (0.7 - 0.04);
  }
};

TEST_CASE("The object's outline is where pose and camera say, to a few hundredths of a pixel") {
  check_outline(kSceneCamera);
}

TEST_CASE("A distorting lens bends the outline as OpenCV's model says") {
  Camera camera = kSceneCamera;
  camera.distortion = {-0.25, 0.08, 0.002, -0.001, 0, 0, 0, 0};
  check_outline(camera);
  camera.distortion = {0.2, 0.1, -0.001, 0.002, 0.05, 0.1, 0.05, 0.01};
  check_outline(camera);
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
  const Sequence sequence(quad, still_options(folder, kSceneCamera, pose));
  const cv::Mat image = sequence.frame(0);
  const double expected = kSceneCamera.cx + 400 * (0.417 - 0.5) / pose.translation().z();
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
    Camera camera = kSceneCamera;
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
  Camera camera = kSceneCamera;
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

TEST_CASE("A bar hides the share of the object that its width says") {
  const TemporaryFolder folder;
  const FrontalBox box;
  SequenceOptions options = still_options(folder, kSceneCamera, box.pose);
  OccluderOptions bar;
  bar.sweeps = 0;
  bar.bar_column = kSceneCamera.cx + 7;
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
  SequenceOptions options = still_options(folder, kSceneCamera, box.pose);
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
  CHECK(Sequence(box.mesh, still_options(folder, kSceneCamera, box.pose)).make(0).visible_share == 0);
}

}  // namespace
}  // namespace holdfast::simulation
