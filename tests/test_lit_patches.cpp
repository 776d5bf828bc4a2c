// How bright surface looks that faces this way or that: read from a frame of known light, and what tracking a small
// curved object gains by it.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "holdfast/tracker.hpp"
#include "imaging/lit_patches.hpp"
#include "simulation/sequence.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

constexpr double kRadius = 0.1;

/// A ball with blotches of paint, some `blotches` along a radius.
Mesh painted_ball(double blotches, double contrast = 45) {
  constexpr int kRings = 96, kSides = 192;
  Mesh mesh;
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j <= kSides; ++j) {
      const double a = std::numbers::pi * i / kRings, b = 2 * std::numbers::pi * j / kSides;
      const Eigen::Vector3d n(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      mesh.positions.push_back((kRadius * n).cast<float>());
      const Eigen::Vector3d q = 2 * blotches * n;
      const auto paint = [&](double phase) {
        const double wave =
            std::sin(1.7 * q.x() + phase) * std::cos(1.3 * q.y() - 2 * phase) + std::sin(1.9 * q.z() + q.x());
        return static_cast<std::uint8_t>(std::lround(120 + contrast * wave));
      };
      mesh.colors.push_back({paint(0.3), paint(1.4), paint(2.5), 255});
    }
  }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * (kSides + 1) + j); };
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kSides; ++j) {
      if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      if (i + 1 < kRings) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return mesh;
}

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

/// Where the ray through a pixel meets the ball: its unit normal, by the formula of a sphere.
Eigen::Vector3d normal_of_ball(const Camera& camera, const Eigen::Vector3d& center, int x, int y) {
  const Eigen::Vector3d ray = Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1).normalized();
  const double along = ray.dot(center);
  const double half2 = kRadius * kRadius - (center.squaredNorm() - along * along);
  return ((along - std::sqrt(std::max(0.0, half2))) * ray - center).normalized();
}

/// The ball drawn as it is painted, then darkened pixel by pixel, as light b falls on a true sphere.
std::vector<std::uint8_t> lit_frame(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object,
                                    const Eigen::Vector3d& b, double gain) {
  Renderer renderer(mesh, camera.width, camera.height);
  const View view = draw(renderer, T_camera_object, camera);
  std::vector<std::uint8_t> rgba = view.rgba;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (!view.drawn(x, y)) continue;
      const Eigen::Vector3d n = normal_of_ball(camera, T_camera_object.translation(), x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& value = rgba[4 * view.index(x, y) + c];
        const double lit = std::min(1.0, gain * value / 255 * (1 + b.dot(n)) / (1 + b.norm()));
        value = static_cast<std::uint8_t>(std::lround(255 * lit));
      }
    }
  }
  return rgba;
}

const Camera kCamera{323, 241, 402, 391, 160.3, 118.7, {}};

/// A ball before the camera in light b: the stages from its frame and its view to patches.
struct LitBall {
  LitBall(const Device& device, const Mesh& mesh, double gain = 1)
      : filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), kCamera, levels, filter),
        test(device.impl(), levels),
        photometry(device.impl(), levels, true),
        patches(device.impl(), levels) {
    const std::vector<std::uint8_t> rgba = lit_frame(mesh, kCamera, T_camera_object, b, gain);
    const Rect whole{0, 0, kCamera.width, kCamera.height};
    image.enqueue_upload(ImageView{rgba.data(), kCamera.width, kCamera.height, 0, PixelFormat::rgba8},
                         image.region(whole));
    image.enqueue_blur(0, whole);
    image.wait_for_upload();
  }

  /// Of the ball drawn unlit, or in this light.
  std::span<const LitPatch> read(const Shading& shading, bool drawn, int every) {
    ViewRequest request;
    request.T_camera_object = T_camera_object;
    if (drawn) request.shading = shading.direction();
    REQUIRE(view.enqueue(request));
    photometry.enqueue_upload(0, view.planes(0).tiles);
    kernel::hf_warp warp = make_warp(levels[0].camera, Pose::Identity(), T_camera_object.translation(), image.valid(0));
    warp.every = every;
    kernel::hf_constraints constraints{};
    constraints.every = every;
    test.enqueue(view, image, 0, warp, make_tests(OcclusionOptions()), constraints, photometry.buffer(0));
    return patches.read(view, test, 0, every, photometry, {shading, drawn});
  }

  const Pose T_camera_object = pose_at({0.03, -0.02, 0.6}, {0.3, 0.5, -0.2});
  const Eigen::Vector3d b{-0.25, -0.3, -0.4};
  std::vector<Level> levels = make_levels(kCamera, 2);
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  FlowConstraints test;
  Photometry photometry;
  LitPatches patches;
};

}  // namespace

TEST_CASE("patches have the surface's normals and the light that falls on it, on both partitions and of thinned rows") {
  const Mesh mesh = painted_ball(4);
  for (const Partition partition : {Partition::strips, Partition::groups}) {
    DeviceOptions device_options;
    device_options.partition = partition;
    const Device device(device_options);
    LitBall ball(device, mesh);
    const Eigen::Vector3d& b = ball.b;
    for (const int every : {1, 2, 3, 4}) {
      CAPTURE(every);
      const auto found = ball.read(Shading(), false, every);
      CHECK(found.size() > 300);
      CHECK(found.size() <= 4000);
      std::vector<double> off;
      double light = 0;
      for (const LitPatch& patch : found) {
        CHECK(patch.normal.norm() == doctest::Approx(1));
        CHECK(patch.normal.z() < 0);
        off.push_back(std::abs(patch.brightness * (1 + b.norm()) / (1 + b.dot(patch.normal)) - 1));
        light = std::max(light, patch.brightness);
      }
      std::sort(off.begin(), off.end());
      CHECK(light <= 1.02);
      CHECK(off[off.size() / 2] < 0.01);
      CHECK(off[off.size() * 9 / 10] < 0.04);
      Shading shading;
      for (int frame = 0; frame < 3; ++frame) shading.learn(found);
      CHECK((shading.direction() - b).norm() < 0.04);
    }
    // The ball's own geometry, at single pixels.
    for (const auto& [x, y] : {std::pair{180, 106}, {150, 80}, {205, 130}, {181, 150}}) {
      const auto normal = ball.view.normal_at(x, y);
      REQUIRE(normal.has_value());
      CHECK(degrees_between(*normal, normal_of_ball(kCamera, ball.T_camera_object.translation(), x, y)) < 3);
    }
    CHECK_FALSE(ball.view.normal_at(20, 20).has_value());
  }
}

TEST_CASE("what is clipped tells nothing of the light") {
  const Device device;
  const Mesh mesh = painted_ball(8);
  LitBall clipped(device, mesh, 1.9);
  Shading shading;
  for (int frame = 0; frame < 3; ++frame) shading.learn(clipped.read(Shading(), false, 1));
  MESSAGE("light is off by ", (shading.direction() - clipped.b).norm());
  CHECK((shading.direction() - clipped.b).norm() < 0.06);
}

TEST_CASE("what light makes of the gradients is told from what paint makes, whether or not it is drawn") {
  const Device device;
  const auto share = [&](const Mesh& mesh, bool drawn) {
    LitBall ball(device, mesh);
    Shading shading;
    shading.learn(ball.read(shading, false, 1));
    ball.read(shading, drawn, 1);
    return ball.patches.light_share();
  };
  for (const bool drawn : {false, true}) {
    CAPTURE(drawn);
    CHECK(share(painted_ball(8), drawn) < 0.05);
    CHECK(share(painted_ball(8, 0), drawn) > 0.8);
  }
  CHECK(share(painted_ball(3, 15), true) == doctest::Approx(share(painted_ball(3, 15), false)).epsilon(0.2));
}

TEST_CASE("light from one side on a small curved object: held, and near; without having it drawn far from it") {
  simulation::SequenceOptions options;
  options.frames = 40;
  options.seed = 4;
  options.motion.nearest = 2.9;
  options.motion.farthest = 3.0;
  options.motion.speed = 2;
  options.sensor.noise = 2;
  options.samples = 4;
  const Mesh mesh = painted_ball(2);
  const simulation::Sequence sequence(mesh, options);
  const auto frames = frames_of(sequence);
  const auto followed = [&](bool shading) {
    TrackerOptions tracked;
    if (!shading) tracked.ablate = {"shading"};
    Tracker tracker(mesh, sequence.camera(), tracked);
    tracker.reset(sequence.pose(0));
    int right = 0;
    for (int i = 0; i < sequence.size(); ++i) {
      const FrameResult result = tracker.track(view_of(frames[static_cast<std::size_t>(i)]));
      const Pose difference = result.T_camera_object * sequence.pose(i).inverse();
      const double turn = Eigen::AngleAxisd(difference.linear()).angle() * 180 / std::numbers::pi;
      const double away = (result.T_camera_object.translation() - sequence.pose(i).translation()).norm();
      if (result.status == Status::held && turn < 3 && away < 0.03) ++right;
    }
    return right;
  };
  CHECK(followed(true) == sequence.size());
  CHECK(followed(false) < sequence.size() / 2);
}
