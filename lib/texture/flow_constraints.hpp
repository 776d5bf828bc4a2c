#pragma once

#include <array>
#include <span>
#include <vector>

#include "holdfast/pose.hpp"
#include "texture/occlusion.hpp"

namespace holdfast {

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

/// Block vote, flow constraints and their reduction: a partial sum a tile on the device, tiles summed here in double
/// and in fixed order.
class FlowConstraints {
 public:
  FlowConstraints(const Device::Impl& device, const std::vector<Level>& levels);

  void enqueue(const ViewTemplate& view, const OcclusionTest& occlusion, int level,
               const kernel::hf_constraints& constraints, const cl::Buffer& photometry);

  /// Waits for the device and sums up. The only blocking call of an iteration.
  ConstraintSums read();

  /// HF_SUM_STRIDE floats a tile of `tiles()`, row by row, of the last read().
  std::span<const float> tile_sums() const { return {partials_.as<const float>(), most_tiles_ * HF_SUM_STRIDE}; }
  const kernel::hf_rect& tiles() const { return tiles_; }
  /// A byte a pixel, values of PixelClass.
  const cl::Buffer& classes(int level) const { return classes_[static_cast<std::size_t>(level)]; }

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  cl::Buffer sums_;
  std::vector<cl::Buffer> classes_;
  std::size_t most_tiles_;
  HostMemory partials_;
  kernel::hf_rect tiles_{};
  cl::Kernel kernel_;
};

}  // namespace holdfast
