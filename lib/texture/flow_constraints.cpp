#include "texture/flow_constraints.hpp"

#include <cmath>

namespace holdfast {

kernel::hf_warp make_warp(const Camera& camera, const Pose& D, const Eigen::Vector3d& p_camera_center,
                          const Rect& valid) {
  kernel::hf_warp warp{};
  to_rows(D, warp.d);
  set_intrinsics(warp, camera);
  // Jacobian of the warp at the object's centre, for a surface that faces the camera there.
  const double z = p_camera_center.z();
  const Eigen::Vector3d q = D * p_camera_center;
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx / q.z(), 0, -camera.fx * q.x() / (q.z() * q.z()), 0, camera.fy / q.z(),
      -camera.fy * q.y() / (q.z() * q.z());
  Eigen::Matrix<double, 3, 2> back_projection;
  back_projection << z / camera.fx, 0, 0, z / camera.fy, 0, 0;
  const Eigen::Matrix2d jacobian = projection * D.linear() * back_projection;
  warp.turn[0] = static_cast<float>(jacobian(0, 0));
  warp.turn[1] = static_cast<float>(jacobian(1, 0));
  warp.turn[2] = static_cast<float>(jacobian(0, 1));
  warp.turn[3] = static_cast<float>(jacobian(1, 1));
  warp.min_x = static_cast<float>(valid.x);
  warp.min_y = static_cast<float>(valid.y);
  // Exclusive: a bilinear sample reads the next pixel too.
  warp.max_x = static_cast<float>(valid.x + valid.width - 1);
  warp.max_y = static_cast<float>(valid.y + valid.height - 1);
  warp.every = 1;
  warp.still = D.matrix() == Eigen::Matrix4d::Identity() ? 1 : 0;
  return warp;
}

kernel::hf_tests make_tests(const OcclusionOptions& options) {
  kernel::hf_tests tests{};
  tests.gradient_test = options.gradient_test ? 1 : 0;
  tests.angle_test = options.angle_test ? 1 : 0;
  tests.magnitude_test = options.magnitude_test ? 1 : 0;
  tests.angle_together = options.angle_together ? 1 : 0;
  tests.gradient_minimum2 = static_cast<float>(options.gradient_minimum * options.gradient_minimum);
  const double cosine = std::cos(options.angle_maximum);
  tests.angle_cosine2 = static_cast<float>(cosine * cosine);
  tests.difference_maximum = static_cast<float>(options.difference_maximum);
  tests.difference_relative = static_cast<float>(options.difference_relative);
  return tests;
}

FlowConstraints::FlowConstraints(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device),
      levels_(levels),
      most_tiles_(static_cast<std::size_t>(levels[0].tiles_x()) * static_cast<std::size_t>(levels[0].tiles_y())),
      partials_(device.host_memory(most_tiles_ * HF_SUM_STRIDE * sizeof(float))) {
  samples_ = device.zeroed_buffer((levels[0].elements + kGuardFloats) * HF_SAMPLES * sizeof(float));
  sums_ = cl::Buffer(device.context, CL_MEM_READ_WRITE, most_tiles_ * HF_SUM_STRIDE * sizeof(float));
  for (const Level& level : levels) {
    tested_.push_back(device.zeroed_buffer(level.elements + kGuardFloats));
    classes_.push_back(device.zeroed_buffer(level.elements + kGuardFloats));
  }
  test_ = device.kernel("occlusion_tests");
  constrain_ = device.kernel("flow_constraints");
}

void FlowConstraints::enqueue(const ViewTemplate& view, const DeviceImage& image, int level_index,
                              const kernel::hf_warp& warp, const kernel::hf_tests& tests,
                              const kernel::hf_constraints& constraints, const cl::Buffer& photometry) {
  const auto l = static_cast<std::size_t>(level_index);
  const Level& level = levels_[l];
  const ViewTemplate::Planes& planes = view.planes(level_index);
  tiles_ = planes.tiles;
  const int plane = static_cast<int>(level.elements);
  set_arguments(test_, planes.dx, planes.dy, plane, planes.depth, planes.usable, level.layout, tiles_,
                image.blurred(level_index), warp, tests, photometry, level.cells_x(), samples_, tested_[l]);
  device_.enqueue_tiles(test_, tiles_.width, tiles_.height);
  set_arguments(constrain_, planes.value, planes.dx, planes.dy, plane, planes.depth, level.layout, tiles_, samples_,
                tested_[l], constraints, photometry, level.cells_x(), classes_[l], sums_);
  device_.enqueue_tiles(constrain_, tiles_.width, tiles_.height);
  const std::size_t count = static_cast<std::size_t>(tiles_.width) * static_cast<std::size_t>(tiles_.height);
  if (count == 0) return;
  device_.queue.enqueueReadBuffer(sums_, CL_FALSE, 0, count * HF_SUM_STRIDE * sizeof(float), partials_.data(), nullptr,
                                  &done_);
}

ConstraintSums FlowConstraints::read() {
  ConstraintSums sums;
  const std::size_t count = static_cast<std::size_t>(tiles_.width) * static_cast<std::size_t>(tiles_.height);
  if (count == 0) return sums;
  done_.wait();
  std::array<double, HF_SUM_MAIN> total{};
  for (std::size_t tile = 0; tile < count; ++tile) {
    const float* partial = partials_.as<const float>() + tile * HF_SUM_STRIDE;
    if (partial[HF_SUM_VISIBLE] == 0.0f) continue;
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += static_cast<double>(partial[i]);
  }
  std::size_t n = HF_SUM_A;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) sums.A(i, j) = sums.A(j, i) = total[n++];
    sums.h(i) = total[static_cast<std::size_t>(HF_SUM_H + i)];
  }
  sums.weighted_square = total[HF_SUM_WRR];
  sums.weight = total[HF_SUM_W];
  sums.rows = total[HF_SUM_ROWS];
  sums.visible = total[HF_SUM_VISIBLE];
  sums.usable = total[HF_SUM_USABLE];
  sums.gradient = total[HF_SUM_GRADIENT];
  sums.passed = total[HF_SUM_PASSED];
  sums.used = total[HF_SUM_USED];
  return sums;
}

}  // namespace holdfast
