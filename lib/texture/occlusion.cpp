#include "texture/occlusion.hpp"

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

OcclusionTest::OcclusionTest(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device), levels_(levels) {
  samples_ = device.zeroed_buffer((levels[0].elements + kGuardFloats) * HF_SAMPLES * sizeof(float));
  for (const Level& level : levels) classes_.push_back(device.zeroed_buffer(level.elements + kGuardFloats));
  kernel_ = device.kernel("occlusion_tests");
}

void OcclusionTest::enqueue(const ViewTemplate& view, const DeviceImage& image, int level_index,
                            const kernel::hf_warp& warp, const kernel::hf_tests& tests, const cl::Buffer& photometry) {
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const ViewTemplate::Planes& planes = view.planes(level_index);
  set_arguments(kernel_, planes.dx, planes.dy, static_cast<int>(level.elements), planes.depth, planes.usable,
                level.layout, planes.tiles, image.blurred(level_index), warp, tests, photometry, level.cells_x(),
                samples_, classes_[static_cast<std::size_t>(level_index)]);
  device_.enqueue_tiles(kernel_, planes.tiles.width, planes.tiles.height);
}

}  // namespace holdfast
