// Holdfast's core in another program, with Eigen alone: a box is rendered, shown to a tracker and found again.
#include <cstdio>
#include <holdfast/camera.hpp>
#include <holdfast/device.hpp>
#include <holdfast/error.hpp>
#include <holdfast/export.hpp>
#include <holdfast/image_view.hpp>
#include <holdfast/mesh.hpp>
#include <holdfast/options.hpp>
#include <holdfast/pose.hpp>
#include <holdfast/renderer.hpp>
#include <holdfast/tracker.hpp>
#include <stdexcept>

namespace {

/// A square of 20 cm with a blocky random texture.
holdfast::Mesh textured_square() {
  holdfast::Mesh mesh;
  mesh.positions = {{-0.1F, -0.1F, 0}, {0.1F, -0.1F, 0}, {0.1F, 0.1F, 0}, {-0.1F, 0.1F, 0}};
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  holdfast::Texture texture;
  texture.width = texture.height = 128;
  unsigned state = 1;
  unsigned cells[16][16];
  for (auto& row : cells) {
    for (auto& cell : row) cell = state = 1664525 * state + 1013904223;
  }
  for (int y = 0; y < texture.height; ++y) {
    for (int x = 0; x < texture.width; ++x) {
      const unsigned cell = cells[y / 8][x / 8];
      for (const int shift : {8, 16, 24}) texture.rgba.push_back(static_cast<std::uint8_t>(cell >> shift));
      texture.rgba.push_back(255);
    }
  }
  mesh.materials = {{"paper", texture}};
  return mesh;
}

int embed() {
  const holdfast::Mesh mesh = textured_square();
  const holdfast::Camera camera{.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 159.5, .cy = 119.5};

  // Rows that run towards the camera's y axis: the square faces the camera, half a metre away.
  holdfast::Pose T_camera_object = holdfast::Pose::Identity();
  T_camera_object.linear() = Eigen::AngleAxisd(2.9, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_camera_object.translation() << 0.01, -0.02, 0.5;

  std::vector<std::uint8_t> frame(4 * 320 * 240);
  holdfast::Renderer renderer(mesh, camera.width, camera.height);
  renderer.render(T_camera_object, camera, {0, 0, camera.width, camera.height}, {.rgba = frame.data()});

  const holdfast::Device device;
  holdfast::Tracker tracker(mesh, camera, holdfast::TrackerOptions{}, device);
  holdfast::Twist motion;
  motion << 0.002, -0.001, 0.003, 0.01, -0.01, 0.005;
  tracker.reset(holdfast::exp_se3(motion) * T_camera_object);
  const holdfast::FrameResult result = tracker.track(
      {.data = frame.data(), .width = camera.width, .height = camera.height, .format = holdfast::PixelFormat::rgba8});

  const holdfast::Pose error = result.T_camera_object * T_camera_object.inverse();
  const double millimetres = 1e3 * (result.T_camera_object.translation() - T_camera_object.translation()).norm();
  std::printf("%s: %s, %.3f mm and %.4f rad off\n", device.info().name.c_str(),
              result.status == holdfast::Status::held ? "held" : "lost", millimetres,
              holdfast::rotation_angle(error.linear()));
  return result.status == holdfast::Status::held && millimetres < 1 ? 0 : 1;
}

/// Exceptions cross the library's border with their type.
bool errors_arrive() {
  try {
    holdfast::Mesh{}.validate();
  } catch (const holdfast::Error& error) {
    return error.code() == holdfast::ErrorCode::model;
  }
  return false;
}

}  // namespace

int main() {
  try {
    return errors_arrive() ? embed() : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
