#include "base/levels.hpp"

#include <algorithm>

namespace holdfast {

std::vector<Level> make_levels(const Camera& camera, int count) {
  const auto round_up = [](int value, int multiple) { return (value + multiple - 1) / multiple * multiple; };
  const int alignment = HF_TILE << (count - 1);
  std::vector<Level> levels(static_cast<std::size_t>(count));
  for (int l = 0; l < count; ++l) {
    Level& level = levels[static_cast<std::size_t>(l)];
    level.index = l;
    const double scale = 1.0 / (1 << l);
    level.width = (camera.width + (1 << l) - 1) >> l;
    level.height = (camera.height + (1 << l) - 1) >> l;
    level.padded_width = round_up(camera.width, alignment) >> l;
    level.padded_height = round_up(camera.height, alignment) >> l;
    level.layout.stride = level.padded_width + 2 * HF_PAD;
    level.layout.origin = HF_PAD * level.layout.stride + HF_PAD;
    level.elements =
        static_cast<std::size_t>(level.layout.stride) * static_cast<std::size_t>(level.padded_height + 2 * HF_PAD);
    level.camera = camera;
    level.camera.width = level.width;
    level.camera.height = level.height;
    level.camera.fx = camera.fx * scale;
    level.camera.fy = camera.fy * scale;
    // A coarse pixel's centre lies between the centres of the pixels it covers.
    level.camera.cx = (camera.cx + 0.5) * scale - 0.5;
    level.camera.cy = (camera.cy + 0.5) * scale - 0.5;
    level.camera.distortion = {};
  }
  return levels;
}

Rect aligned(const Rect& rect, int alignment, int width, int height) {
  const auto down = [&](int value) { return value >= 0 ? value / alignment * alignment : 0; };
  const auto up = [&](int value) { return (value + alignment - 1) / alignment * alignment; };
  const int x0 = down(rect.x), y0 = down(rect.y);
  const int x1 = std::min(width, up(std::max(0, rect.x + rect.width)));
  const int y1 = std::min(height, up(std::max(0, rect.y + rect.height)));
  if (x1 <= x0 || y1 <= y0) return {};
  return {x0, y0, x1 - x0, y1 - y0};
}

Rect united(const Rect& a, const Rect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const int x0 = std::min(a.x, b.x), y0 = std::min(a.y, b.y);
  const int x1 = std::max(a.x + a.width, b.x + b.width), y1 = std::max(a.y + a.height, b.y + b.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace holdfast
