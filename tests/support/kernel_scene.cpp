#include "support/kernel_scene.hpp"

#include <random>

#include "holdfast/pose.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast::test {

Scene::Scene(Size s, unsigned seed)
    : size(s),
      level(level_of(s)),
      value(s.width, s.height, 3),
      dx(s.width, s.height, 3),
      dy(s.width, s.height, 3),
      depth(s.width, s.height, 1),
      frame(s.width, s.height, HF_PIXEL),
      features(s.width, s.height, 9),
      cells(level.cells_x(), level.cells_y(), HF_CELL_PAIRS),
      usable(level.elements + kGuardFloats, 0),
      tiles{0, 0, level.tiles_x(), level.tiles_y()},
      camera{level.camera.fx, level.camera.fy, level.camera.cx, level.camera.cy} {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(0, 1);
  const auto f = [](double number) { return static_cast<double>(static_cast<float>(number)); };
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool flat = ((x / 7) + (y / 17)) % 4 == 0;
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = f(0.5 + (flat ? 0.003 : 0.085) * normal(random));
      frame.at(x, y, 3) = ((x / 9) + (y / 5)) % 23 == 0 ? 0.1 : 1.0;  // here and there nothing was recorded
    }
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      // Patches in which the view agrees and patches in which it does not, so that votes go both ways.
      const bool agrees = ((x / 13) + (y / 11)) % 3 != 0;
      const double noise = agrees ? 0.006 : 0.08;
      for (int c = 0; c < 3; ++c) {
        features.at(x, y, c) = frame.get(x, y, c);
        features.at(x, y, 3 + c) = (frame.get(x + 1, y, c) - frame.get(x - 1, y, c)) / 2;
        features.at(x, y, 6 + c) = (frame.get(x, y + 1, c) - frame.get(x, y - 1, c)) / 2;
        value.at(x, y, c) = f(frame.get(x, y, c) + 0.02 * normal(random));
        dx.at(x, y, c) = f((agrees ? features.get(x, y, 3 + c) : 0.0) + noise * normal(random));
        dy.at(x, y, c) = f((agrees ? features.get(x, y, 6 + c) : 0.0) + noise * normal(random));
      }
      depth.at(x, y, 0) = f(0.6 + 0.1 * uniform(random));
      const double draw = uniform(random);
      usable[element(level, x, y)] = draw < 0.05 ? HF_NOT_VISIBLE : draw < 0.1 ? HF_UNUSABLE : HF_USED;
    }
  }
  for (double& pair : cells.values) pair = f(uniform(random));
  for (int y = 0; y < cells.height; ++y) {
    for (int x = 0; x < cells.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        cells.at(x, y, c) = f(0.9 + 0.2 * uniform(random));
        cells.at(x, y, 3 + c) = f(0.1 * uniform(random) - 0.05);
      }
    }
  }
}

kernel::hf_warp small_warp(const Scene& scene, double scale) {
  Twist twist;
  twist << 0.002, -0.001, 0.003, 0.004, -0.006, 0.005;
  twist *= scale;
  const Rect valid{0, 0, scene.size.width, scene.size.height};
  return make_warp(scene.level.camera, exp_se3(twist), Eigen::Vector3d(0.01, 0.02, 0.65), valid);
}

SceneOnDevice::SceneOnDevice(const Device::Impl& device, const Scene& scene)
    : device_(device),
      scene_(scene),
      sums_count_(static_cast<std::size_t>(scene.tiles.width * scene.tiles.height) * HF_SUM_STRIDE),
      value_(upload(device, to_plane_memory(scene.value, scene.level))),
      dx_(upload(device, to_plane_memory(scene.dx, scene.level))),
      dy_(upload(device, to_plane_memory(scene.dy, scene.level))),
      depth_(upload(device, to_plane_memory(scene.depth, scene.level))),
      usable_(upload(device, scene.usable)),
      frame_(upload(device, to_memory(scene.frame, scene.level))),
      cells_(upload(device, std::vector<float>(scene.cells.values.begin(), scene.cells.values.end()))),
      samples_(zeroed(device, scene.level, HF_SAMPLES)),
      classes_(zeroed<std::uint8_t>(device, scene.level)),
      final_classes_(zeroed<std::uint8_t>(device, scene.level)),
      sums_(device.zeroed_buffer(sums_count_ * sizeof(float))) {}

void SceneOnDevice::clear() const {
  device_.queue.enqueueFillBuffer(classes_, static_cast<cl_uchar>(kUntouched), 0, scene_.level.elements);
  device_.queue.enqueueFillBuffer(samples_, 0.0f, 0, scene_.level.elements * HF_SAMPLES * sizeof(float));
}

void SceneOnDevice::run_tests(const kernel::hf_warp& warp, const kernel::hf_tests& tests) const {
  cl::Kernel kernel = device_.kernel("occlusion_tests");
  set_arguments(kernel, dx_, dy_, static_cast<int>(scene_.level.elements), depth_, usable_, scene_.level.layout,
                scene_.tiles, frame_, warp, tests, cells_, scene_.level.cells_x(), samples_, classes_);
  device_.enqueue_tiles(kernel, scene_.tiles.width, scene_.tiles.height);
}

std::vector<std::uint8_t> SceneOnDevice::classes() const {
  return download<std::uint8_t>(device_, classes_, scene_.level.elements);
}

std::vector<float> SceneOnDevice::samples() const {
  return download<float>(device_, samples_, scene_.level.elements * HF_SAMPLES);
}

std::vector<float> SceneOnDevice::run_constraints(const kernel::hf_constraints& constraints) const {
  cl::Kernel kernel = device_.kernel("flow_constraints");
  set_arguments(kernel, value_, dx_, dy_, static_cast<int>(scene_.level.elements), depth_, scene_.level.layout,
                scene_.tiles, samples_, classes_, constraints, cells_, scene_.level.cells_x(), final_classes_, sums_);
  device_.enqueue_tiles(kernel, scene_.tiles.width, scene_.tiles.height);
  return download<float>(device_, sums_, sums_count_);
}

std::vector<std::uint8_t> SceneOnDevice::final_classes() const {
  return download<std::uint8_t>(device_, final_classes_, scene_.level.elements);
}

std::vector<float> SceneOnDevice::run_shift_scores(const Rect& shifts, int step) const {
  const Level& level = scene_.level;
  const auto elements = static_cast<int>(level.elements);
  const cl::Buffer gradients = zeroed(device_, level, 7);
  cl::Kernel differentiate = device_.kernel("frame_gradients");
  set_arguments(differentiate, frame_, level.layout, to_kernel(whole(level)), gradients, elements);
  device_.enqueue_rows(differentiate, level.padded_width, level.padded_height);

  const auto count = static_cast<std::size_t>(shifts.width * shifts.height);
  const cl::Buffer scores = device_.zeroed_buffer(count * sizeof(float));
  const cl_int4 sampled{{1, 1, scene_.size.width - 2, scene_.size.height - 2}};
  cl::Kernel kernel = device_.kernel("shift_scores");
  set_arguments(kernel, dx_, dy_, elements, usable_, level.layout, to_kernel(whole(level)), step, gradients, elements,
                sampled, cl_int2{{shifts.x, shifts.y}}, shifts.width, scores);
  const int columns = device_.strips ? (shifts.width + 15) / 16 : shifts.width;
  device_.queue.enqueueNDRangeKernel(
      kernel, cl::NullRange, cl::NDRange(static_cast<std::size_t>(columns), static_cast<std::size_t>(shifts.height)),
      cl::NDRange(1, 1));
  return download<float>(device_, scores, count);
}

}  // namespace holdfast::test
