#pragma once

#include <cstdint>

#include "holdfast/tracker.hpp"
#include "video/frame_source.hpp"

namespace holdfast::app {

/// A frame on its way from the tracker to the files.
struct TrackedFrame {
  Frame frame;  ///< its image is another frame's unless `pictured`
  FrameResult result;
  bool located = true;       ///< false until the object is found for the first time: the result has no pose
  std::int64_t ordinal = 0;  ///< 0 for the first frame tracked
  bool pictured = false;     ///< somebody draws this frame: image and mask are there
  PixelMask mask;
};

}  // namespace holdfast::app
