// Two trackers on one device, each in a thread of its own, follow an object as one alone does. For ThreadSanitizer,
// which also looks at test_pipeline.cpp here.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <random>
#include <thread>
#include <vector>

#include "holdfast/renderer.hpp"
#include "holdfast/tracker.hpp"

namespace {

using namespace holdfast;

constexpr Camera kCamera{160, 120, 170, 170, 79.5, 59.5, {}};
constexpr int kFrames = 6;

Texture print() {
  Texture texture;
  texture.width = texture.height = 32;
  std::mt19937 random(7);
  for (int i = 0; i < 32 * 32; ++i) {
    const auto grey = static_cast<std::uint8_t>(random() % 256);
    texture.rgba.insert(texture.rgba.end(), {grey, static_cast<std::uint8_t>(random() % 256), grey, 255});
  }
  return texture;
}

/// A box of 0.2 x 0.16 x 0.1 m, the same print on all sides.
Mesh box() {
  Mesh mesh;
  const std::array<float, 3> half = {0.1F, 0.08F, 0.05F};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const auto& [s, t] : {std::pair{-1.0F, -1.0F}, {1.0F, -1.0F}, {1.0F, 1.0F}, {-1.0F, 1.0F}}) {
        Eigen::Vector3f p;
        p[static_cast<int>(axis)] = side * half[axis];
        p[static_cast<int>((axis + 1) % 3)] = side * s * half[(axis + 1) % 3];
        p[static_cast<int>((axis + 2) % 3)] = t * half[(axis + 2) % 3];
        mesh.positions.push_back(p);
        mesh.texture_coordinates.emplace_back((s + 1) / 2, (t + 1) / 2);
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  mesh.materials.push_back({"print", print()});
  return mesh;
}

Pose pose(int frame) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(0.6 + 0.01 * frame, Eigen::Vector3d(1, 0.8, 0.2).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.002 * frame, 0.001 * frame, 0.5);
  return T;
}

/// Views before plain grey, RGBA.
std::vector<std::vector<std::uint8_t>> frames(const Mesh& mesh) {
  Renderer renderer(mesh, kCamera.width, kCamera.height);
  std::vector<std::vector<std::uint8_t>> all;
  for (int i = 0; i < kFrames; ++i) {
    std::vector<std::uint8_t>& rgba = all.emplace_back(std::size_t{160} * 120 * 4);
    renderer.render(pose(i), kCamera, {0, 0, kCamera.width, kCamera.height}, {rgba.data(), nullptr, 0});
    for (std::size_t k = 0; k < rgba.size(); k += 4) {
      if (rgba[k + 3] == 0) rgba[k] = rgba[k + 1] = rgba[k + 2] = 90;
    }
  }
  return all;
}

std::vector<FrameResult> follow(const Mesh& mesh, const Device& device,
                                const std::vector<std::vector<std::uint8_t>>& views) {
  Tracker tracker(mesh, kCamera, {}, device);
  tracker.reset(pose(0));
  std::vector<FrameResult> results;
  for (const auto& rgba : views) {
    results.push_back(tracker.track(ImageView{rgba.data(), kCamera.width, kCamera.height, 0, PixelFormat::rgba8}));
  }
  return results;
}

}  // namespace

TEST_CASE("two trackers on one device follow as one alone does") {
  const Mesh mesh = box();
  const auto views = frames(mesh);
  const Device device;
  const std::vector<FrameResult> alone = follow(mesh, device, views);
  std::array<std::vector<FrameResult>, 2> together;
  {
    std::vector<std::jthread> threads;
    for (auto& results : together) threads.emplace_back([&] { results = follow(mesh, device, views); });
  }
  for (const auto& results : together) {
    REQUIRE(results.size() == alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      CHECK(alone[i].status == Status::held);
      CHECK(results[i].status == alone[i].status);
      CHECK(results[i].T_camera_object.matrix() == alone[i].T_camera_object.matrix());
    }
  }
}
