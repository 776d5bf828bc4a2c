#pragma once

#include <array>
#include <vector>

#include "flow_constraints.hpp"

namespace holdfast {

/// Gain and bias between model texture and frame, I = gain V + bias a channel: one pair for the whole object, carried
/// from frame to frame, and one a tile around it, because light falls differently on every face (equations 15 and 16 of
/// docs/math.md).
class Photometry {
 public:
  Photometry(const Device::Impl& device, const std::vector<Level>& levels, bool enabled);

  /// Gain 1, bias 0.
  void reset();

  /// Fills every tile of a level with the object's pair, or with what the tile's place on the next coarser level had.
  void start_level(int level, const kernel::hf_rect& tiles, bool from_coarser);

  /// Takes new pairs from the sums of the last iteration. No-op when not enabled.
  void update(int level, const FlowConstraints& constraints);

  /// Uploads the tiles' pairs (only the rows given).
  void enqueue_upload(int level, const kernel::hf_rect& tiles);

  const cl::Buffer& buffer(int level) const { return tiles_[static_cast<std::size_t>(level)].buffer; }
  double gain(int channel) const { return gain_[static_cast<std::size_t>(channel)]; }
  double bias(int channel) const { return bias_[static_cast<std::size_t>(channel)]; }

  /// Correlation of view and frame within the tiles' neighbourhoods over the used pixels, of the last update.
  static double correlation(const FlowConstraints& constraints);

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  bool enabled_;
  std::vector<TilePhotometry> tiles_;
  std::array<double, HF_CHANNELS> gain_{1, 1, 1}, bias_{0, 0, 0};
};

}  // namespace holdfast
