#include "edges/edge_candidates.hpp"

#include <algorithm>

namespace holdfast {

EdgeCandidates::EdgeCandidates(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device), levels_(levels) {
  lines_.resize(kMostLines * HF_EDGE_LINE);
  found_.resize(kMostLines * HF_EDGE_CANDIDATES);
  lines_buffer_ = device.zeroed_buffer(lines_.size() * sizeof(float));
  found_buffer_ = device.zeroed_buffer(found_.size() * sizeof(EdgeCandidate));
  kernel_ = device.kernel("edge_candidates");
}

void EdgeCandidates::find(DeviceImage& image, int level, std::span<const VisibleEdge> edges, const EdgeMemory& memory) {
  if (edges.empty()) return;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const VisibleEdge& edge = edges[i];
    float* line = lines_.data() + i * HF_EDGE_LINE;
    EdgeMemory::Look look;
    if (!memory.looks.empty()) look = memory.looks[static_cast<std::size_t>(edge.sample)];
    const bool known = look.faces == edge.faces;  // another face beside it is another edge
    const Eigen::Vector2f pixel = edge.pixel.cast<float>(), normal = edge.normal.cast<float>();
    std::copy_n(pixel.data(), 2, line);
    std::copy_n(normal.data(), 2, line + 2);
    std::copy_n(look.step.data(), 3, line + 4);
    line[7] = known ? 1.0F : 0.0F;
  }
  image.enqueue_pixels(level);
  device_.queue.enqueueWriteBuffer(lines_buffer_, CL_FALSE, 0, edges.size() * HF_EDGE_LINE * sizeof(float),
                                   lines_.data());
  kernel::hf_edges o{};
  o.region = to_kernel(image.uploaded(level));
  o.count = static_cast<int>(edges.size());
  set_arguments(kernel_, image.pixels(level), levels_[static_cast<std::size_t>(level)].layout, lines_buffer_, o,
                found_buffer_);
  device_.enqueue_items(kernel_, edges.size());
  device_.queue.enqueueReadBuffer(found_buffer_, CL_TRUE, 0, edges.size() * HF_EDGE_CANDIDATES * sizeof(EdgeCandidate),
                                  found_.data());
}

}  // namespace holdfast
