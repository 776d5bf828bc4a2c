// Pictures of what was tracked: the outline drawn, the pixels coloured, the lens' distortion removed.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "track/outline.hpp"
#include "track/overlay.hpp"

using holdfast::Camera;
using holdfast::Mesh;
using holdfast::Pose;
using namespace holdfast::app;

namespace {

double length_of(const std::vector<Line>& lines) {
  double length = 0;
  for (const Line& line : lines) {
    length += (line.end - line.begin).norm();
  }
  return length;
}

/// Eight corners, each once a face so that every face has texture coordinates of its own.
Mesh cube(double edge) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        Eigen::Vector3f p;
        p[axis] = static_cast<float>(side);
        p[(axis + 1) % 3] = corner == 1 || corner == 2 ? 1.0F : -1.0F;
        p[(axis + 2) % 3] = corner >= 2 ? 1.0F : -1.0F;
        mesh.positions.push_back(p * static_cast<float>(edge / 2));
        mesh.colors.push_back({200, 200, 200, 255});
      }
      const auto at = [first, side](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        return side > 0 ? std::array<std::uint32_t, 3>{first + a, first + b, first + c}
                        : std::array<std::uint32_t, 3>{first + a, first + c, first + b};
      };
      mesh.triangles.push_back(at(0, 1, 2));
      mesh.triangles.push_back(at(0, 2, 3));
    }
  }
  return mesh;
}

Mesh sphere(double radius, int rings, int sectors) {
  Mesh mesh;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double polar = M_PI * i / rings;
      const double around = 2 * M_PI * j / sectors;
      mesh.positions.push_back((radius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                         std::sin(polar) * std::sin(around), std::cos(polar)))
                                   .cast<float>());
      mesh.colors.push_back({200, 200, 200, 255});
    }
  }
  const auto at = [sectors](int i, int j) { return static_cast<std::uint32_t>(i * sectors + j % sectors); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) {
        mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      }
      if (i < rings - 1) {
        mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
      }
    }
  }
  return mesh;
}

const Camera kCamera{640, 480, 600, 620, 310.5, 245.5, {}};

}  // namespace

TEST_CASE("a cube's outline is the edges of the faces that are seen, without triangulation and texture seams") {
  const Mesh mesh = cube(0.2);
  Outline outline(mesh, kCamera);
  for (const auto& [turn, t] : std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>{
           {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.8}},
           {{0.5, -0.7, 0.2}, {0.05, -0.03, 0.9}},
           {{-2.0, 1.0, 0.4}, {-0.1, 0.08, 1.2}},
       }) {
    Pose T_camera_object(Eigen::AngleAxisd(
        turn.norm(), turn.norm() > 0 ? Eigen::Vector3d(turn.normalized()) : Eigen::Vector3d::UnitX()));
    T_camera_object.translation() = t;
    // A cube is convex: a face is seen exactly when it faces the camera, an edge when one of its faces is.
    double wanted = 0;
    int faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double u : {-0.1, 0.1}) {
        for (const double v : {-0.1, 0.1}) {
          const auto point = [&](double along) {
            Eigen::Vector3d p;
            p[axis] = along;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return Eigen::Vector3d(T_camera_object * p);
          };
          const auto faces_camera = [&](int normal_axis, double side) {
            const Eigen::Vector3d normal = T_camera_object.linear().col(normal_axis) * side;
            return normal.dot(point(0)) < 0;
          };
          const bool seen = faces_camera((axis + 1) % 3, u) || faces_camera((axis + 2) % 3, v);
          if (seen) {
            wanted += (kCamera.project(point(0.1)) - kCamera.project(point(-0.1))).norm();
            ++faces;
          }
        }
      }
    }
    const std::vector<Line>& lines = outline.lines(T_camera_object);
    CAPTURE(faces);
    CHECK(length_of(lines) == doctest::Approx(wanted).epsilon(0.02));
  }
}

TEST_CASE("a sphere's outline is its silhouette") {
  Outline outline(sphere(0.1, 40, 60), kCamera);
  Pose T_camera_object(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 1, 0).normalized()));
  T_camera_object.translation() = Eigen::Vector3d(0, 0, 0.7);
  const std::vector<Line>& lines = outline.lines(T_camera_object);
  // Tangent cone of half-angle asin(radius / distance).
  const double tangent = std::tan(std::asin(0.1 / 0.7));
  REQUIRE(lines.size() > 20);
  for (const Line& line : lines) {
    for (const Eigen::Vector2d& end : {line.begin, line.end}) {
      const double radius = std::hypot((end.x() - kCamera.cx) / kCamera.fx, (end.y() - kCamera.cy) / kCamera.fy);
      CHECK(radius == doctest::Approx(tangent).epsilon(0.02));
    }
  }
}

TEST_CASE("an outline keeps inside the frame, and is empty where the object is not in view") {
  Outline outline(cube(0.2), kCamera);
  Pose T_camera_object = Pose::Identity();
  T_camera_object.translation() = Eigen::Vector3d(0.45, 0, 0.9);  // half outside
  const std::vector<Line>& cut = outline.lines(T_camera_object);
  CHECK_FALSE(cut.empty());
  for (const Line& line : cut) {
    for (const Eigen::Vector2d& end : {line.begin, line.end}) {
      CHECK(end.x() < kCamera.width + 2);
      CHECK(end.x() > 0);
    }
  }
  T_camera_object.translation() = Eigen::Vector3d(3, 0, 0.9);
  CHECK(outline.lines(T_camera_object).empty());
  T_camera_object.translation() = Eigen::Vector3d(0, 0, -0.9);
  CHECK(outline.lines(T_camera_object).empty());
}

TEST_CASE("pictures show the frame as the tracker sees it: without lens distortion") {
  Camera camera = kCamera;
  camera.distortion = {-0.3, 0.1, 0.002, -0.001, 0, 0, 0, 0};
  const Eigen::Vector2d straight(520, 90);
  const Eigen::Vector2d recorded = camera.distort(straight);
  REQUIRE((recorded - straight).norm() > 5);
  TrackedFrame tracked;
  tracked.frame.image = cv::Mat::zeros(camera.height, camera.width, CV_8UC3);
  cv::circle(tracked.frame.image, {static_cast<int>(recorded.x() * 16), static_cast<int>(recorded.y() * 16)}, 48,
             cv::Scalar::all(255), cv::FILLED, cv::LINE_AA, 4);
  tracked.result.T_camera_object.translation() = Eigen::Vector3d(0, 0, -1);  // nothing to draw
  Overlay overlay(cube(0.2), camera);
  cv::Mat grey;
  cv::cvtColor(overlay.outline_picture(tracked), grey, cv::COLOR_BGR2GRAY);
  REQUIRE(grey.size() == cv::Size(camera.width, camera.height));
  const cv::Moments moments = cv::moments(grey);
  CHECK(std::abs(moments.m10 / moments.m00 - straight.x()) < 0.3);
  CHECK(std::abs(moments.m01 / moments.m00 - straight.y()) < 0.3);
}

TEST_CASE("an overlay's labels do not touch, however narrow the picture and long the words") {
  for (const int width : {160, 320, 640, 1920}) {
    CAPTURE(width);
    const Camera camera{width, 3 * width / 4, 1.0 * width, 1.0 * width, 0.5 * width, 0.375 * width, {}};
    Overlay overlay(cube(0.2), camera);
    TrackedFrame tracked;
    tracked.frame.image = cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar::all(128));
    tracked.frame.index = 123456;
    tracked.frame.time_s = 4115.2;
    tracked.result.T_camera_object.translation().z() = 0.8;
    tracked.result.ms.total = 118.4;
    tracked.mask.width = camera.width;
    tracked.mask.height = camera.height;
    tracked.mask.classes.assign(static_cast<std::size_t>(camera.width) * camera.height, 6);  // a large number
    for (const std::string& reason : {std::string(), std::string(150, 'm')}) {
      tracked.result.message = reason;
      const cv::Mat picture = overlay.overlay_picture(tracked).clone();
      const int panel = picture.cols / 2;
      const cv::Mat strip = picture.rowRange(picture.rows - 50, picture.rows);
      // Nothing is written where the left part's words end and the right one's begin, nor up to the edge.
      const auto is_empty = [&](int from, int to) {
        return cv::norm(strip.colRange(from, to), cv::Mat(strip.rows, to - from, CV_8UC3, strip.at<cv::Vec3b>(49, 0)),
                        cv::NORM_INF) == 0;
      };
      CHECK(is_empty(panel - 7, panel + 8));
      CHECK(is_empty(picture.cols - 4, picture.cols));
      if (!reason.empty()) CHECK_FALSE(is_empty(panel - 60, panel - 7));  // smaller, not cut off
    }
  }
}

TEST_CASE("an overlay tells used pixels from rejected ones by colour, and held from lost") {
  Overlay overlay(cube(0.2), kCamera);
  TrackedFrame tracked;
  tracked.frame.image = cv::Mat(kCamera.height, kCamera.width, CV_8UC3, cv::Scalar::all(128));
  tracked.result.T_camera_object.translation() = Eigen::Vector3d(0, 0, 0.8);
  tracked.mask.width = kCamera.width;
  tracked.mask.height = kCamera.height;
  tracked.mask.classes.assign(static_cast<std::size_t>(kCamera.width) * kCamera.height, 0);
  for (int value = 0; value <= 6; ++value) {  // a column of the picture each
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 20 * value; x < 20 * value + 20; ++x) {
        tracked.mask.classes[static_cast<std::size_t>(y) * kCamera.width + x] = static_cast<std::uint8_t>(value);
      }
    }
  }
  const cv::Mat picture = overlay.overlay_picture(tracked).clone();
  REQUIRE(picture.size() == overlay.overlay_size());
  CHECK(picture.cols == 2 * kCamera.width);
  CHECK(picture.rows % 2 == 0);
  const auto color_of = [&](holdfast::PixelClass shown) {
    return cv::Vec3i(picture.at<cv::Vec3b>(100, kCamera.width + 20 * static_cast<int>(shown) + 10));
  };
  using holdfast::PixelClass;
  const cv::Vec3i used = color_of(PixelClass::used);
  CHECK(used[1] > used[0] + 60);
  CHECK(used[1] > used[2] + 60);
  for (const PixelClass rejected :
       {PixelClass::rejected_angle, PixelClass::rejected_magnitude, PixelClass::rejected_vote}) {
    CAPTURE(static_cast<int>(rejected));
    CHECK(color_of(rejected)[2] > color_of(rejected)[1] + 60);
    for (const PixelClass other : {PixelClass::rejected_angle, PixelClass::rejected_magnitude,
                                   PixelClass::rejected_vote, PixelClass::no_gradient, PixelClass::unusable}) {
      CHECK((other == rejected || cv::norm(color_of(rejected) - color_of(other)) > 40));
    }
  }
  const cv::Vec3i background = color_of(PixelClass::not_visible);
  CHECK(background[0] == background[2]);

  // The front face's upper edge, at the left of the picture.
  const Eigen::Vector2d edge = kCamera.project(Eigen::Vector3d(0, -0.1, 0.7));
  const auto line_color = [&](const cv::Mat& of) {
    return cv::Vec3i(of.at<cv::Vec3b>(static_cast<int>(std::lround(edge.y())), static_cast<int>(edge.x())));
  };
  tracked.result.status = holdfast::Status::held;
  const cv::Vec3i held = line_color(overlay.overlay_picture(tracked));
  tracked.result.status = holdfast::Status::lost;
  const cv::Vec3i lost = line_color(overlay.overlay_picture(tracked));
  CHECK(held[1] > held[2] + 60);
  CHECK(lost[2] > lost[1] + 60);
}

TEST_CASE("an overlay shows lines across the contour large enough to be seen, where the contour holds the object") {
  Overlay overlay(cube(0.2), kCamera);
  TrackedFrame tracked;
  tracked.frame.image = cv::Mat(kCamera.height, kCamera.width, CV_8UC3, cv::Scalar::all(128));
  tracked.result.T_camera_object.translation() = Eigen::Vector3d(0, 0, -1);  // nothing to draw
  tracked.mask.width = kCamera.width;
  tracked.mask.height = kCamera.height;
  tracked.mask.classes.assign(static_cast<std::size_t>(kCamera.width) * kCamera.height, 0);
  tracked.mask.classes[static_cast<std::size_t>(100) * kCamera.width + 50] =
      static_cast<std::uint8_t>(holdfast::PixelClass::used);
  const auto green_pixels = [&] {
    const cv::Mat picture = overlay.overlay_picture(tracked)(cv::Rect(kCamera.width + 40, 90, 21, 21));
    cv::Mat channels[3], green;
    cv::split(picture, channels);
    cv::compare(channels[1], channels[2] + 40, green, cv::CMP_GT);
    return cv::countNonZero(green);
  };
  CHECK(green_pixels() == 1);
  tracked.result.contour.asked = true;
  CHECK(green_pixels() >= 9);
  tracked.result.texture.holds = true;
  CHECK(green_pixels() == 1);
}
