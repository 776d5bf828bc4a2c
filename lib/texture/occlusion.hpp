#pragma once

#include <vector>

#include "holdfast/options.hpp"
#include "image/device_image.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// A pose as kernels take it: rows of 3x4.
inline void to_rows(const Pose& pose, float (&rows)[12]) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) rows[4 * row + column] = static_cast<float>(pose(row, column));
  }
}

/// Where the rendered view is looked for in the frame: equation 5 of docs/math.md.
kernel::hf_warp make_warp(const Camera& level_camera, const Pose& D, const Eigen::Vector3d& p_camera_center,
                          const Rect& valid);

/// Tests (5) to (7) of a level.
kernel::hf_tests make_tests(const OcclusionOptions& options);

/// Samples the frame at the warped pixels and classifies them.
class OcclusionTest {
 public:
  OcclusionTest(const Device::Impl& device, const std::vector<Level>& levels);

  void enqueue(const ViewTemplate& view, const DeviceImage& image, int level, const kernel::hf_warp& warp,
               const kernel::hf_tests& tests, const cl::Buffer& photometry);

  /// Planes of warped values, HF_SAMPLES of Level::elements floats, of the level last enqueued.
  const cl::Buffer& samples() const { return samples_; }
  /// A byte a pixel: class, plus HF_COUNTS_IN_VOTE.
  const cl::Buffer& classes(int level) const { return classes_[static_cast<std::size_t>(level)]; }

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  cl::Buffer samples_;
  std::vector<cl::Buffer> classes_;
  cl::Kernel kernel_;
};

}  // namespace holdfast
