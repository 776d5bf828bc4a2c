#pragma once

#include <cstddef>
#include <vector>

#include "base/corner_motion.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// A drawn view's depth: `depth` holds the pixels `rect` of the camera's picture, window depth, 1 where nothing is.
struct DrawnDepth {
  const float* depth = nullptr;
  Rect rect;
  DepthRange range;

  /// Window depth of a pixel of the picture; 1 outside of what was drawn.
  float at(int x, int y) const {
    if (x < rect.x || y < rect.y || x >= rect.x + rect.width || y >= rect.y + rect.height) return 1.0F;
    return depth[static_cast<std::ptrdiff_t>(y - rect.y) * rect.width + (x - rect.x)];
  }
};

/// The object's depth as it was drawn last in this frame, for modalities that look at its shape. A cache of the frame
/// at hand: they ask for a pose and a level, and what was drawn near enough is taken again.
class DepthView {
 public:
  /// Pixels around the object that are drawn too.
  static constexpr int kMargin = 15;

  DepthView(const std::vector<Level>& levels, const Extent& extent, ViewTemplate& view);

  /// Forgets what was drawn of the frame before.
  void start_frame() { level_ = -1; }

  /// Draws the object at a pose, unless what was drawn last at this level is within so many of its pixels. False where
  /// the object is out of view.
  bool draw(const Pose& T_camera_object, int level, double within_pixels);

  const DrawnDepth& drawn() const { return drawn_; }
  const Pose& T_drawn() const { return T_drawn_; }
  int level() const { return level_; }  ///< -1: nothing is drawn
  /// Another number whenever it is drawn anew.
  int version() const { return version_; }
  /// Pixels of the frame inside the silhouette.
  int visible_pixels() const;

 private:
  const std::vector<Level>& levels_;
  Extent extent_;
  ViewTemplate& view_;
  std::vector<float> depth_;
  DrawnDepth drawn_;
  Pose T_drawn_ = Pose::Identity();
  int level_ = -1;
  int version_ = 0;
};

}  // namespace holdfast
