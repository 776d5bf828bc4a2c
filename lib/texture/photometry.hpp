#pragma once

#include <array>
#include <span>
#include <vector>

#include "texture/flow_constraints.hpp"
#include "texture/score_covariance.hpp"

namespace holdfast {

/// Of a filtered channel of the frame: at least so bright it may be clipped, itself or in part. Frames are compressed,
/// so that this is 247 of 255.
inline constexpr double kSaturated = 0.97;

/// Takes from a motion, conditioned, what light explains altogether. Light is eliminated with the geometry of cells'
/// middles, so that of few pixels far from them it may take more than the rows say (`A_rows`), and what is left, `A`,
/// is less than nothing along some motions. A motion y becomes `result` y, A becomes result^T A result, h result^T h.
/// The identity where A is positive definite.
Matrix6 left_beside_light(const Matrix6& A, const Matrix6& A_rows);

/// Gain and bias between model texture and frame, I = gain V + bias a channel: one pair for the whole object, carried
/// from frame to frame, and one a cell of HF_CELL pixels around it, interpolated between cells, because light falls
/// differently on every part of a surface (equations 15 and 16 of docs/math.md).
class Photometry {
 public:
  Photometry(const Device::Impl& device, const std::vector<Level>& levels, bool enabled);

  /// The object's own gain and bias a channel.
  struct ObjectPair {
    std::array<double, HF_CHANNELS> gain{1, 1, 1}, bias{0, 0, 0};
  };
  ObjectPair object_pair() const { return {gain_, bias_}; }
  void set_object_pair(const ObjectPair& pair) {
    gain_ = pair.gain;
    bias_ = pair.bias;
  }

  /// The view is drawn brighter by this from now on: the object's gain, for what was drawn before, goes down by it.
  void view_brightened(double factor) {
    for (double& gain : gain_) gain /= factor;
  }

  /// No level has cells of its own any more: before a frame.
  void forget_cells();

  /// Fills the cells of these tiles of a level with the object's pair, or with what their place has on the coarser
  /// level `from_level`, as far as the last view there reached.
  void start_level(int level, const kernel::hf_rect& tiles, int from_level = -1);

  /// Takes new pairs from the sums of the last iteration. No-op when not enabled.
  void update(int level, const FlowConstraints& constraints);

  /// Whether eliminate() does anything.
  bool eliminates() const { return enabled_; }

  /// What the pairs' own uncertainty takes from the constraints: eliminates a gain and a bias a channel and block of
  /// cells from the sums (Schur complement, equation 17 of docs/math.md), so that pose and light are solved for
  /// together. `k` as the sums were made with. No-op when not enabled.
  void eliminate(const FlowConstraints& constraints, const kernel::hf_constraints& k, ConstraintSums& sums) const;
  /// The same for the tiles one by one, whose total `sums` is; and what moves their edges to their darker side.
  void eliminate(const FlowConstraints& constraints, const kernel::hf_constraints& k, const ConstraintSums& sums,
                 std::span<TileEquations> equations) const;

  /// Uploads the cells' pairs (whole rows of cells of these tiles).
  void enqueue_upload(int level, const kernel::hf_rect& tiles);

  const cl::Buffer& buffer(int level) const { return cells_[static_cast<std::size_t>(level)].buffer; }
  double gain(int channel) const { return gain_[static_cast<std::size_t>(channel)]; }

  /// Correlation of view and frame over the used pixels of the last sums, each cell about its own means.
  static double correlation(const FlowConstraints& constraints);

 private:
  static constexpr std::size_t kMoments = 6 * HF_CHANNELS;

  struct LevelCells {
    std::vector<float> pairs;  ///< HF_CELL_PAIRS a cell, rows of Level::cells_x()
    cl::Buffer buffer;
    kernel::hf_rect tiles{};  ///< whose cells the last view filled
  };

  /// Whether the last view of a level filled this cell.
  bool has(int level, int cell_x, int cell_y) const;

  void blur_moments(int columns, int rows);

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  bool enabled_;
  std::vector<LevelCells> cells_;
  std::vector<float> moments_, blurred_;  ///< kMoments a cell of the region at hand
  std::array<double, HF_CHANNELS> gain_{1, 1, 1}, bias_{0, 0, 0};
};

}  // namespace holdfast
