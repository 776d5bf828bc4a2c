#pragma once

#include <array>
#include <span>
#include <vector>

#include "image/view_template.hpp"
#include "imaging/shading.hpp"
#include "texture/flow_constraints.hpp"
#include "texture/photometry.hpp"

namespace holdfast {

/// How the view was drawn that patches are read of.
struct DrawnLight {
  Shading shading;
  bool lit = false;  ///< it was drawn with this shading
};

/// How bright the frame shows surface that faces this way or that: view and samples of the frame -> patches, a pixel
/// each. Whether a pixel passed the tests does not matter, since light that is not drawn yet makes it fail.
class LitPatches {
 public:
  LitPatches(const Device::Impl& device, const std::vector<Level>& levels);

  /// Of the view and the samples last made, on the level that both were made at, which is the finest drawn; `every` as
  /// the samples' rows. Some thousands of pixels of a large object. Waits for the device.
  std::span<const LitPatch> read(const ViewTemplate& view, const FlowConstraints& samples, int level, int every,
                                 const Photometry& photometry, const DrawnLight& drawn);

  /// Of the view last read: what share of its gradients, squared and summed, light makes or would make.
  double light_share() const { return light_ > 0 ? light_ / (light_ + texture_) : 0; }

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  std::size_t most_;  ///< pixels of a plane
  HostMemory planes_, classes_;
  std::vector<LitPatch> patches_;
  double texture_ = 0, light_ = 0;
};

}  // namespace holdfast
