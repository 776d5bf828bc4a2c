#pragma once

#include <optional>
#include <vector>

namespace holdfast::baking {

struct PackedSize {
  int width = 0;
  int height = 0;
};

struct PackedPlace {
  int x = 0;
  int y = 0;
};

/// Places rectangles in a strip of a width, as low as each will go (the skyline method); they do not overlap and are
/// not turned.
class SkylinePacker {
 public:
  explicit SkylinePacker(int width);

  /// Where it lies now; nothing when it is wider than the strip.
  std::optional<PackedPlace> place(const PackedSize& size);

  /// Height of the strip in use.
  int height() const { return height_; }

 private:
  struct Segment {
    int x = 0;
    int width = 0;
    int y = 0;  // what lies below is taken
  };

  int width_;
  int height_ = 0;
  std::vector<Segment> skyline_;  // by rising x, without gaps
};

}  // namespace holdfast::baking
