#pragma once

#include <optional>
#include <vector>

#include "image/device_image.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// Finds by how many whole pixels of a level the view is displaced in the frame: a score a shift, the best wins.
class ShiftSearch {
 public:
  ShiftSearch(const Device::Impl& device, const std::vector<Level>& levels);

  struct Result {
    double dx = 0, dy = 0;  ///< pixels of the level, refined between whole shifts
    double score = 0;       ///< agreement of gradients, at most 1
    double unshifted = 0;   ///< agreement without shift, where that is among the shifts
  };

  /// Shifts by up to `radius` pixels both ways.
  static Rect within(int radius) { return {-radius, -radius, 2 * radius + 1, 2 * radius + 1}; }

  /// Prepares the blurred frame's level for search(); once a frame.
  void enqueue_gradients(const DeviceImage& image, int level);

  /// Shifts by [x, x + width) x [y, y + height). `scored_pixels`: pixels that shifts are scored with, about; `part`: of
  /// the view, pixels of the level. Waits for the device.
  Result search(const ViewTemplate& view, const DeviceImage& image, int level, const Rect& shifts, double scored_pixels,
                std::optional<Rect> part = {});

 private:
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  cl::Buffer gradients_, scores_buffer_;
  std::vector<float> scores_;
  cl::Kernel frame_gradients_, kernel_;
};

}  // namespace holdfast
