#include <cstddef>
#include <cstdint>
#include <vector>

#include "holdfast/tracker.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {

PixelMask Tracker::pixel_mask() const {
  return with_device_errors("reading the pixel mask", [&] {
    Impl& impl = *impl_;
    if (impl.last_by_outline_) {
      PixelMask mask{impl.camera_.width, impl.camera_.height, {}};
      mask.classes.assign(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height), 0);
      impl.outline_.classify(impl.T_shown_, impl.finest_, mask.classes);
      return mask;
    }
    impl.look_at_last();
    impl.decide_all_pixels();
    const int level_index = impl.finest_drawn_;
    const Level& level = impl.levels_[static_cast<std::size_t>(level_index)];
    const auto& tiles = impl.view_.planes(level_index).tiles;
    PixelMask mask;
    mask.width = impl.camera_.width;
    mask.height = impl.camera_.height;
    mask.classes.assign(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height), 0);
    if (!impl.decided_) return mask;
    std::vector<std::uint8_t> classes(level.elements);
    impl.device_.impl().queue.enqueueReadBuffer(impl.constraints_.classes(level_index), CL_TRUE, 0, classes.size(),
                                                classes.data());
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        const int lx = x >> level_index, ly = y >> level_index;
        if (lx < tiles.x * HF_TILE || ly < tiles.y * HF_TILE || lx >= (tiles.x + tiles.width) * HF_TILE ||
            ly >= (tiles.y + tiles.height) * HF_TILE) {
          continue;
        }
        mask.classes[static_cast<std::size_t>(y * mask.width + x)] =
            classes[static_cast<std::size_t>(level.layout.origin + ly * level.layout.stride + lx)];
      }
    }
    return mask;
  });
}

RenderedView Tracker::rendered_view() const {
  Impl& impl = *impl_;
  RenderedView view;
  view.width = impl.camera_.width;
  view.height = impl.camera_.height;
  view.T_camera_object = impl.last_by_outline_ ? impl.T_shown_ : impl.T_compared_;
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  view.rgba.assign(count * 4, 0);
  view.depth.assign(count, 1.0f);
  impl.draw_plainly();
  const DepthRange range =
      impl.view_.renderer().render(view.T_camera_object, impl.levels_[0].camera, {0, 0, view.width, view.height},
                                   {view.rgba.data(), view.depth.data(), 0});
  for (float& depth : view.depth) {
    depth = depth < 1.0f ? static_cast<float>(range.metric(static_cast<double>(depth))) : 0.0f;
  }
  return view;
}

}  // namespace holdfast
