#include "texture/flow_constraints.hpp"

namespace holdfast {

FlowConstraints::FlowConstraints(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device),
      levels_(levels),
      most_tiles_(static_cast<std::size_t>(levels[0].tiles_x()) * static_cast<std::size_t>(levels[0].tiles_y())),
      partials_(device.host_memory(most_tiles_ * HF_SUM_STRIDE * sizeof(float))) {
  sums_ = cl::Buffer(device.context, CL_MEM_READ_WRITE, most_tiles_ * HF_SUM_STRIDE * sizeof(float));
  for (const Level& level : levels) classes_.push_back(device.zeroed_buffer(level.elements + kGuardFloats));
  kernel_ = device.kernel("flow_constraints");
}

void FlowConstraints::enqueue(const ViewTemplate& view, const OcclusionTest& occlusion, int level_index,
                              const kernel::hf_constraints& constraints, const cl::Buffer& photometry) {
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const ViewTemplate::Planes& planes = view.planes(level_index);
  tiles_ = planes.tiles;
  set_arguments(kernel_, planes.value, planes.dx, planes.dy, static_cast<int>(level.elements), planes.depth,
                level.layout, planes.tiles, occlusion.samples(), occlusion.classes(level_index), constraints,
                photometry, level.cells_x(), classes_[static_cast<std::size_t>(level_index)], sums_);
  device_.enqueue_tiles(kernel_, planes.tiles.width, planes.tiles.height);
}

ConstraintSums FlowConstraints::read() {
  ConstraintSums sums;
  const std::size_t count = static_cast<std::size_t>(tiles_.width) * static_cast<std::size_t>(tiles_.height);
  if (count == 0) return sums;
  device_.queue.enqueueReadBuffer(sums_, CL_TRUE, 0, count * HF_SUM_STRIDE * sizeof(float), partials_.data());
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
