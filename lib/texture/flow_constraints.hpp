#pragma once

#include <array>
#include <span>
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

/// The motion between the rendered view and the frame that it is looked for in: equation 5 of docs/math.md.
kernel::hf_warp make_warp(const Camera& level_camera, const Pose& D, const Eigen::Vector3d& p_camera_center,
                          const Rect& valid);

/// Tests (5) to (7) of a level.
kernel::hf_tests make_tests(const OcclusionOptions& options);

/// Sums of all tiles, in double.
struct ConstraintSums {
  Matrix6 A = Matrix6::Zero();  ///< conditioned: translation in object radii, rotation about the object's centre
  Twist h = Twist::Zero();
  double weighted_square = 0;  ///< sum of w r^2
  double weight = 0;
  double rows = 0;
  Matrix6 A_rows = Matrix6::Zero();  ///< A before light was eliminated
  /// What is left of a motion beside light (left_beside_light()), already taken from A and h.
  Matrix6 beside_light = Matrix6::Identity();
  double scale = 0;  ///< of residuals, that the weights were made with
  double visible = 0, usable = 0, gradient = 0, passed = 0, used = 0;  ///< pixels
};

/// Samples the frame at the warped pixels and classifies them; then block vote, flow constraints and their reduction: a
/// partial sum a tile on the device, tiles summed here in double and in fixed order.
class FlowConstraints {
 public:
  FlowConstraints(const Device::Impl& device, const std::vector<Level>& levels);

  void enqueue(const ViewTemplate& view, const DeviceImage& image, int level, const kernel::hf_warp& warp,
               const kernel::hf_tests& tests, const kernel::hf_constraints& constraints, const cl::Buffer& photometry);

  /// Waits for the device and sums up what was enqueued last.
  ConstraintSums read();

  /// HF_SUM_STRIDE floats a tile of `tiles()`, row by row, of the last read().
  std::span<const float> tile_sums() const { return {partials_.as<const float>(), most_tiles_ * HF_SUM_STRIDE}; }
  const kernel::hf_rect& tiles() const { return tiles_; }
  /// Planes of warped values, HF_SAMPLES of Level::elements floats, of the level last enqueued.
  const cl::Buffer& samples() const { return samples_; }
  /// A byte a pixel, values of PixelClass.
  const cl::Buffer& classes(int level) const { return classes_[static_cast<std::size_t>(level)]; }

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  cl::Buffer samples_, sums_;
  std::vector<cl::Buffer> tested_;  ///< a byte a pixel before the vote: class, plus HF_COUNTS_IN_VOTE
  std::vector<cl::Buffer> classes_;
  std::size_t most_tiles_;
  HostMemory partials_;
  kernel::hf_rect tiles_{};
  cl::Kernel test_, constrain_;
  cl::Event done_;
};

}  // namespace holdfast
