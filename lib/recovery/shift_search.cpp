#include "recovery/shift_search.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

constexpr std::size_t kGradientPlanes = 7;

/// Offset of a parabola's maximum through three equidistant values, in (-0.5, 0.5).
double parabola_peak(double left, double center, double right) {
  const double curvature = left - 2 * center + right;
  if (curvature >= -1e-9) return 0;
  return std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5);
}

}  // namespace

ShiftSearch::ShiftSearch(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device), levels_(levels) {
  // Searched is never the finest of several levels.
  const Level& largest = levels[std::min<std::size_t>(1, levels.size() - 1)];
  gradients_ = device.zeroed_buffer((largest.elements + kGuardFloats) * kGradientPlanes * sizeof(float));
  frame_gradients_ = device.kernel("frame_gradients");
  kernel_ = device.kernel("shift_scores");
}

void ShiftSearch::enqueue_gradients(const DeviceImage& image, int level_index) {
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const Rect& valid = image.valid(level_index);
  const Rect rect = aligned(valid, 4, level.padded_width, level.padded_height);
  set_arguments(frame_gradients_, image.blurred(level_index), level.layout, to_kernel(rect), gradients_,
                static_cast<int>(level.elements));
  device_.enqueue_rows(frame_gradients_, rect.width, rect.height);
}

ShiftSearch::Result ShiftSearch::search(const ViewTemplate& view, const DeviceImage& image, int level_index,
                                        const Rect& shifts, double scored_pixels, std::optional<Rect> part_of_view) {
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const ViewTemplate::Planes& planes = view.planes(level_index);
  const Rect part = part_of_view.value_or(planes.drawn());
  const int step = std::max(1, static_cast<int>(std::sqrt(0.5 * part.width * part.height / scored_pixels)));
  const Rect& valid = image.valid(level_index);
  const auto columns = static_cast<std::size_t>(shifts.width), rows = static_cast<std::size_t>(shifts.height);
  if (columns * rows > scores_.size()) {
    scores_.resize(columns * rows);
    scores_buffer_ = device_.zeroed_buffer(scores_.size() * sizeof(float));
  }
  const cl_int4 sampled{{valid.x, valid.y, valid.x + valid.width - 1, valid.y + valid.height - 1}};
  set_arguments(kernel_, planes.dx, planes.dy, static_cast<int>(level.elements), planes.usable, level.layout,
                to_kernel(part), step, gradients_, static_cast<int>(level.elements), sampled,
                cl_int2{{shifts.x, shifts.y}}, shifts.width, scores_buffer_);
  const std::size_t items = device_.strips ? (columns + 15) / 16 : columns;
  device_.queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(items, rows), cl::NDRange(1, 1));
  device_.queue.enqueueReadBuffer(scores_buffer_, CL_TRUE, 0, columns * rows * sizeof(float), scores_.data());

  const auto score = [&](int x, int y) {
    return static_cast<double>(scores_[static_cast<std::size_t>((y - shifts.y) * shifts.width + x - shifts.x)]);
  };
  const int right = shifts.x + shifts.width, bottom = shifts.y + shifts.height;
  const auto searched = [&](int x, int y) { return x >= shifts.x && y >= shifts.y && x < right && y < bottom; };
  const bool begins_at_rest = searched(0, 0);
  int best_x = begins_at_rest ? 0 : shifts.x, best_y = begins_at_rest ? 0 : shifts.y;
  Result result;
  if (begins_at_rest) result.unshifted = score(0, 0);
  for (int y = shifts.y; y < bottom; ++y) {
    for (int x = shifts.x; x < right; ++x) {
      if (score(x, y) > score(best_x, best_y)) {
        best_x = x;
        best_y = y;
      }
    }
  }
  result.score = score(best_x, best_y);
  result.dx = best_x;
  result.dy = best_y;
  if (searched(best_x - 1, best_y) && searched(best_x + 1, best_y)) {
    result.dx += parabola_peak(score(best_x - 1, best_y), result.score, score(best_x + 1, best_y));
  }
  if (searched(best_x, best_y - 1) && searched(best_x, best_y + 1)) {
    result.dy += parabola_peak(score(best_x, best_y - 1), result.score, score(best_x, best_y + 1));
  }
  return result;
}

}  // namespace holdfast
