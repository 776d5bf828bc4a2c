#pragma once

#include <cstddef>
#include <vector>

#include "device/shared.h"
#include "holdfast/camera.hpp"
#include "holdfast/image_view.hpp"

namespace holdfast {

/// Elements that a row kernel may touch beyond a buffer's last pixel.
constexpr std::size_t kGuardFloats = 64;

/// Size and memory layout of one pyramid level; level l has pixels of 2^l x 2^l pixels of the frame.
struct Level {
  int index = 0;  ///< 0: the frame's own resolution
  int width = 0;  ///< pixels with any of the frame in them
  int height = 0;
  int padded_width = 0;  ///< whole tiles on this and every coarser level
  int padded_height = 0;
  kernel::hf_layout layout{};
  std::size_t elements = 0;  ///< pixels of memory, padding included
  Camera camera;             ///< intrinsics of this level
  int tiles_x() const { return padded_width / HF_TILE; }
  int tiles_y() const { return padded_height / HF_TILE; }
  int cells_x() const { return padded_width / HF_CELL; }
  int cells_y() const { return padded_height / HF_CELL; }
};

/// A camera as kernels take it.
template <typename Parameters>
void set_intrinsics(Parameters& parameters, const Camera& camera) {
  parameters.fx = static_cast<float>(camera.fx);
  parameters.fy = static_cast<float>(camera.fy);
  parameters.cx = static_cast<float>(camera.cx);
  parameters.cy = static_cast<float>(camera.cy);
}

/// Levels 0 (the frame's own resolution) to count - 1.
std::vector<Level> make_levels(const Camera& camera, int count);

/// Grown to multiples of `alignment` in position and size and clipped to [0, width) x [0, height), which must be
/// multiples themselves. Empty when nothing is left.
Rect aligned(const Rect& rect, int alignment, int width, int height);

/// The rectangle on a level `down` steps coarser; exact for rectangles aligned to 2^down.
inline Rect coarser(const Rect& rect, int down) {
  return {rect.x >> down, rect.y >> down, rect.width >> down, rect.height >> down};
}

/// Grown by `margin` pixels on every side.
inline Rect grown(const Rect& rect, int margin) {
  return {rect.x - margin, rect.y - margin, rect.width + 2 * margin, rect.height + 2 * margin};
}

/// True where `inner` lies within `outer`, which is not empty.
inline bool contains(const Rect& outer, const Rect& inner) {
  return !outer.empty() && inner.x >= outer.x && inner.y >= outer.y && inner.x + inner.width <= outer.x + outer.width &&
         inner.y + inner.height <= outer.y + outer.height;
}

/// The smallest rectangle that holds both.
Rect united(const Rect& a, const Rect& b);

}  // namespace holdfast
