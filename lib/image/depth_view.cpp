#include "image/depth_view.hpp"

#include <algorithm>

namespace holdfast {

DepthView::DepthView(const std::vector<Level>& levels, const Extent& extent, ViewTemplate& view)
    : levels_(levels), extent_(extent), view_(view) {
  depth_.resize(levels[0].elements);
}

bool DepthView::draw(const Pose& T_camera_object, int level_index, double within_pixels) {
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  if (level_index == level_ && corner_motion(extent_, level.camera, T_drawn_, T_camera_object) <= within_pixels) {
    return true;
  }
  level_ = -1;
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return false;
  const Rect wanted = grown({object.x >> level_index, object.y >> level_index, (object.width >> level_index) + 2,
                             (object.height >> level_index) + 2},
                            kMargin);
  const Rect rect = aligned(wanted, 4, level.padded_width, level.padded_height);
  if (rect.empty()) return false;
  drawn_.range = view_.renderer().render(T_camera_object, level.camera, rect, {nullptr, depth_.data(), rect.width});
  drawn_.depth = depth_.data();
  drawn_.rect = rect;
  T_drawn_ = T_camera_object;
  level_ = level_index;
  ++version_;
  return true;
}

int DepthView::visible_pixels() const {
  const Level& level = levels_[static_cast<std::size_t>(level_)];
  int count = 0;
  for (int y = 0; y < drawn_.rect.height && drawn_.rect.y + y < level.height; ++y) {
    const float* row = drawn_.depth + static_cast<std::ptrdiff_t>(y) * drawn_.rect.width;
    const int width = std::min(drawn_.rect.width, level.width - drawn_.rect.x);
    count += static_cast<int>(std::count_if(row, row + width, [](float depth) { return depth < 1.0F; }));
  }
  return count << (2 * level_);
}

}  // namespace holdfast
