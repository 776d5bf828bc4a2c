#pragma once

#include <span>
#include <vector>

#include "edges/edge_memory.hpp"
#include "edges/visible_edges.hpp"
#include "image/device_image.hpp"

namespace holdfast {

/// An edge of the frame on a line across one of the model's.
struct EdgeCandidate {
  float offset = 0;                                ///< pixels of the level along the line's normal
  float weight = 0;                                ///< 0: none; at most 1
  Eigen::Vector3f step = Eigen::Vector3f::Zero();  ///< of colour along the normal
  Eigen::Vector3f unused = Eigen::Vector3f::Zero();
};
static_assert(sizeof(EdgeCandidate) == HF_EDGE_CANDIDATE * sizeof(float));

/// Finds the frame's edges along lines across the model's, on the device.
class EdgeCandidates {
 public:
  static constexpr std::size_t kMostLines = 256;

  EdgeCandidates(const Device::Impl& device, const std::vector<Level>& levels);

  /// Looks for HF_EDGE_CANDIDATES a line. Waits for the device.
  void find(DeviceImage& image, int level, std::span<const VisibleEdge> edges, const EdgeMemory& memory);
  /// Those of a line, of the last find(), the most telling first.
  std::span<const EdgeCandidate> of(std::size_t line) const {
    return std::span(found_).subspan(line * HF_EDGE_CANDIDATES, HF_EDGE_CANDIDATES);
  }

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  std::vector<float> lines_;
  std::vector<EdgeCandidate> found_;
  cl::Buffer lines_buffer_, found_buffer_;
  cl::Kernel kernel_;
};

}  // namespace holdfast
