// holdfast::io in another program: a camera, a pose and a model go to files and come back.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <holdfast/camera.hpp>
#include <holdfast/io.hpp>
#include <holdfast/mesh.hpp>
#include <holdfast/pose.hpp>

int main() {
  try {
    const auto folder = std::filesystem::current_path();
    const holdfast::Camera camera{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 320, .cy = 240};
    holdfast::io::save_camera(folder / "camera.yml", camera);
    holdfast::Pose T_camera_object = holdfast::Pose::Identity();
    T_camera_object.translation().z() = 0.7;
    holdfast::io::save_pose(folder / "pose.txt", T_camera_object);
    holdfast::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 0.1F}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    holdfast::io::save_model(folder / "model.obj", mesh);

    const bool same = holdfast::io::load_camera(folder / "camera.yml").fy == camera.fy &&
                      holdfast::io::load_pose(folder / "pose.txt").isApprox(T_camera_object) &&
                      holdfast::io::load_model(folder / "model.obj").triangles.size() == 4;
    std::printf("files: %s\n", same ? "as written" : "not as written");
    return same ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
