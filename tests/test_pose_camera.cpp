#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/error.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {
namespace {

using std::numbers::pi;

/// The definition: the power series of the 4x4 matrix, halved until it converges fast, then squared back.
Eigen::Matrix4d exp_by_series(const Twist& twist) {
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  generator(0, 1) = -twist[5];
  generator(0, 2) = twist[4];
  generator(1, 0) = twist[5];
  generator(1, 2) = -twist[3];
  generator(2, 0) = -twist[4];
  generator(2, 1) = twist[3];
  generator.topRightCorner<3, 1>() = twist.head<3>();
  constexpr int kHalvings = 4;
  generator /= std::pow(2.0, kHalvings);
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d term = sum;
  for (int k = 1; k < 30; ++k) {
    term = term * generator / k;
    sum += term;
  }
  for (int i = 0; i < kHalvings; ++i) {
    sum = (sum * sum).eval();
  }
  return sum;
}

/// Twists at no rotation, at every order of magnitude of rotation up to just below pi, and at random.
std::vector<Twist> twists() {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized().eval();
  };
  std::vector<double> angles = {0, 0.19, 0.2, 0.21, 1, 2, 3, pi - 1e-1, pi / 2};
  for (int exponent = -16; exponent <= -1; ++exponent) {
    angles.push_back(std::pow(10.0, exponent));
    angles.push_back(pi - std::pow(10.0, std::max(exponent, -12)));
  }
  angles.push_back(1e-200);
  std::vector<Twist> result = {Twist::Zero()};
  for (const double angle : angles) {
    for (int i = 0; i < 5; ++i) {
      Twist twist;
      twist << direction() * std::abs(normal(random)), direction() * angle;
      result.push_back(twist);
    }
    for (int axis = 0; axis < 3; ++axis) {
      Twist twist;
      twist << direction(), Eigen::Vector3d::Unit(axis) * angle;
      result.push_back(twist);
    }
  }
  return result;
}

double largest_difference(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// The nearest rotation by another way: Newton's iteration for the polar decomposition.
Eigen::Matrix3d polar_rotation(Eigen::Matrix3d matrix) {
  for (int i = 0; i < 60; ++i) {
    matrix = ((matrix + matrix.inverse().transpose()) / 2).eval();
  }
  return matrix;
}

template <typename Action>
Error error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error;
  }
  FAIL("no error was thrown");
  return Error(ErrorCode::file, "");
}

const Camera kCamera{640, 480, 611.3, 587.9, 331.7, 228.4, {}};

}  // namespace

TEST_CASE("The exponential is the matrix power series, translation first, rotation second") {
  for (const Twist& twist : twists()) {
    CHECK(largest_difference(exp_se3(twist).matrix(), exp_by_series(twist)) < 2e-14);
  }
  CHECK(exp_se3(Twist::Zero()).matrix() == Eigen::Matrix4d::Identity());
  Twist quarter_turn;
  quarter_turn << 0, 0, 0, 0, 0, pi / 2;  // about z: x goes to y
  CHECK((exp_se3(quarter_turn) * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 0)).norm() < 1e-15);
  Twist shift;
  shift << 1, 2, 3, 0, 0, 0;
  CHECK(exp_se3(shift).translation() == Eigen::Vector3d(1, 2, 3));
}

TEST_CASE("A small twist moves points by v + w x P") {
  const Eigen::Vector3d point(0.3, -0.2, 0.7);
  Twist twist;
  twist << 0.4, -0.1, 0.2, 0.3, 0.5, -0.6;
  const double step = 1e-7;
  const Eigen::Vector3d moved = exp_se3(step * twist) * point;
  const Eigen::Vector3d velocity = (moved - point) / step;
  CHECK((velocity - twist.head<3>() - twist.tail<3>().cross(point)).norm() < 1e-6);
}

TEST_CASE("The logarithm inverts the exponential up to pi") {
  for (const Twist& twist : twists()) {
    CAPTURE(twist.tail<3>().norm());
    CHECK((log_se3(exp_se3(twist)) - twist).cwiseAbs().maxCoeff() < 2e-14);
  }
  CHECK(log_se3(Pose::Identity()) == Twist::Zero());
}

TEST_CASE("The logarithm keeps the digits of tiny twists") {
  Twist twist;
  twist << 1e-9, -2e-9, 3e-9, 4e-9, -5e-9, 6e-9;
  CHECK((log_se3(exp_se3(twist)) - twist).norm() < 1e-14 * twist.norm());
}

TEST_CASE("At a rotation by exactly pi the logarithm is one of the two that exponentiate back") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d axis = i < 3 ? Eigen::Vector3d(Eigen::Vector3d::Unit(i))
                                       : Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    Pose pose = Pose::Identity();
    pose.linear() = 2 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
    pose.translation() = Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Twist twist = log_se3(pose);
    CHECK(twist.tail<3>().norm() == doctest::Approx(pi).epsilon(1e-12));
    CHECK(largest_difference(exp_se3(twist).matrix(), pose.matrix()) < 1e-14);
  }
}

TEST_CASE("The angle of a rotation is exact near 0 and near pi") {
  for (const double angle : {0.0, 1e-12, 1e-7, 0.3, 1.5, 3.0, pi - 1e-7, pi - 1e-12, pi}) {
    const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    CHECK(std::abs(rotation_angle(rotation) - angle) < 2e-15);
  }
}

TEST_CASE("Renormalising gives the nearest rotation and keeps the translation") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    Twist twist;
    for (double& value : twist) {
      value = normal(random);
    }
    Pose drifted = exp_se3(twist);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        drifted.matrix()(row, column) += 0.05 * normal(random);
      }
    }
    const Pose result = renormalized(drifted);
    CHECK((result.linear() - polar_rotation(drifted.linear())).cwiseAbs().maxCoeff() < 1e-13);
    CHECK((result.linear().transpose() * result.linear() - Eigen::Matrix3d::Identity()).norm() < 1e-14);
    CHECK(result.linear().determinant() > 0);
    CHECK(result.translation() == drifted.translation());
    CHECK_NOTHROW(validate_pose(result, 1e-12));
  }
  Pose mirrored = Pose::Identity();
  mirrored.matrix().diagonal() << 1, 1, -0.2, 1;
  CHECK((renormalized(mirrored).linear() - Eigen::Matrix3d::Identity()).norm() < 1e-14);
}

TEST_CASE("A pose that is no rigid motion is an error") {
  CHECK_NOTHROW(validate_pose(exp_se3(Twist::Ones())));
  Pose pose = Pose::Identity();
  pose.matrix()(0, 0) = 1.0004;
  CHECK_NOTHROW(validate_pose(pose));
  CHECK(error_of([&] { validate_pose(pose, 1e-4); }).code() == ErrorCode::pose);
  pose.matrix()(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(error_of([&] { validate_pose(pose); }).code() == ErrorCode::pose);
  pose = Pose::Identity();
  pose.translation().z() = std::numeric_limits<double>::infinity();
  CHECK(error_of([&] { validate_pose(pose); }).code() == ErrorCode::pose);
  pose = Pose::Identity();
  pose.matrix()(2, 2) = -1;
  CHECK(error_of([&] { validate_pose(pose); }).code() == ErrorCode::pose);
  pose = Pose::Identity();
  pose.matrix()(3, 0) = 1;
  CHECK(error_of([&] { validate_pose(pose); }).code() == ErrorCode::pose);
  pose = Pose::Identity();
  pose.linear() *= 2;
  CHECK(error_of([&] { validate_pose(pose); }).code() == ErrorCode::pose);
}

TEST_CASE("A fisheye's projection is OpenCV's") {
  Camera camera = kCamera;
  camera.lens = LensModel::fisheye;
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  for (const cv::Vec4d& model : {cv::Vec4d(0, 0, 0, 0), cv::Vec4d(0.05, -0.01, 0.004, -0.0006)}) {
    std::copy_n(model.val, 4, camera.distortion.begin());
    CHECK(camera.has_distortion());
    std::vector<cv::Point3d> points;
    for (double x = -3; x <= 3; x += 0.5) {
      for (double y = -2; y <= 2; y += 0.5) points.emplace_back(x, y, 1.1);
    }
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, model);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d ideal = camera.project({points[i].x, points[i].y, points[i].z});
      CHECK((camera.distort(ideal) - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm() < 1e-9);
    }
  }
}

TEST_CASE("Projection and distortion are OpenCV's") {
  const std::array<std::array<double, 8>, 4> models = {{{},
                                                        {-0.28, 0.09, 0, 0, 0, 0, 0, 0},
                                                        {-0.31, 0.12, 0.0011, -0.0007, -0.02, 0, 0, 0},
                                                        {0.2, 0.1, 0.001, 0.002, 0.03, 0.25, 0.12, 0.04}}};
  const cv::Matx33d K(kCamera.fx, 0, kCamera.cx, 0, kCamera.fy, kCamera.cy, 0, 0, 1);
  for (const auto& model : models) {
    Camera camera = kCamera;
    camera.distortion = model;
    CHECK(camera.has_distortion() == (&model != &models[0]));
    std::vector<cv::Point3d> points;
    for (double x = -0.5; x <= 0.5; x += 0.1) {
      for (double y = -0.4; y <= 0.4; y += 0.1) {
        points.emplace_back(x, y, 1.1);
      }
    }
    const std::vector<double> coefficients(model.begin(), model.end());
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, coefficients, pixels);
    double error = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d ideal = camera.project({points[i].x, points[i].y, points[i].z});
      error = std::max(error, (camera.distort(ideal) - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm());
    }
    CHECK(error < 1e-10);
  }
  // By hand: x = 0.5, y = 0.25, r^2 = 0.3125, k1 = 0.1: radial 1.03125.
  Camera camera{100, 100, 100, 200, 50, 40, {0.1, 0, 0, 0, 0, 0, 0, 0}};
  CHECK(camera.project({1, 0.5, 2}) == Eigen::Vector2d(100, 90));
  CHECK((camera.distort({100, 90}) - Eigen::Vector2d(101.5625, 91.5625)).norm() < 1e-12);
}

TEST_CASE("A rescaled camera sees the same rays: pixel borders, not centres, scale") {
  Camera camera = kCamera;
  camera.distortion = {-0.28, 0.09, 0.001, 0.002, 0, 0, 0, 0};
  const Camera half = camera.rescaled(320, 160);
  CHECK(half.width == 320);
  CHECK(half.height == 160);
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-0.4, 0.3, 0.9)}) {
    const Eigen::Vector2d full_pixel = camera.distort(camera.project(point));
    const Eigen::Vector2d half_pixel = half.distort(half.project(point));
    CHECK(half_pixel.x() == doctest::Approx((full_pixel.x() + 0.5) / 2 - 0.5).epsilon(1e-13));
    CHECK(half_pixel.y() == doctest::Approx((full_pixel.y() + 0.5) / 3 - 0.5).epsilon(1e-13));
  }
  CHECK(error_of([&] { camera.rescaled(0, 100); }).code() == ErrorCode::camera);
  camera.width = 0;
  CHECK(error_of([&] { camera.rescaled(320, 240); }).code() == ErrorCode::camera);
}

TEST_CASE("A camera that cannot be is an error") {
  CHECK_NOTHROW(kCamera.validate());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Camera> broken(8, kCamera);
  broken[0].width = 0;
  broken[1].height = -1;
  broken[2].fx = 0;
  broken[3].fy = -500;
  broken[4].cx = nan;
  broken[5].cy = std::numeric_limits<double>::infinity();
  broken[6].distortion[7] = nan;
  broken[7].fx = nan;
  for (const Camera& camera : broken) {
    CHECK(error_of([&] { camera.validate(); }).code() == ErrorCode::camera);
  }
}

TEST_CASE("Sizes of frames in memory") {
  CHECK(packed_stride(PixelFormat::bgr8, 17) == 51);
  CHECK(packed_stride(PixelFormat::rgb8, 17) == 51);
  CHECK(packed_stride(PixelFormat::rgba8, 17) == 68);
  CHECK(packed_stride(PixelFormat::grey8, 17) == 17);
  CHECK(packed_stride(PixelFormat::nv12, 18) == 18);
  CHECK(packed_stride(PixelFormat::yuyv, 18) == 36);
  CHECK(frame_bytes(PixelFormat::bgr8, 10, 64) == 640);
  CHECK(frame_bytes(PixelFormat::nv12, 10, 64) == 960);
  CHECK(Rect{3, 4, 0, 5}.empty());
  CHECK(!Rect{-3, -4, 1, 1}.empty());
}

}  // namespace holdfast
