#include "baking/skyline_packer.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace holdfast::baking {

SkylinePacker::SkylinePacker(int width) : width_(width), skyline_{{0, width, 0}} {}

std::optional<PackedPlace> SkylinePacker::place(const PackedSize& size) {
  PackedPlace best;
  int best_top = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < skyline_.size() && skyline_[i].x + size.width <= width_; ++i) {
    const int right = skyline_[i].x + size.width;
    int y = 0;
    for (std::size_t j = i; j < skyline_.size() && skyline_[j].x < right; ++j) {
      y = std::max(y, skyline_[j].y);
    }
    if (y + size.height < best_top) {
      best_top = y + size.height;
      best = {skyline_[i].x, y};
    }
  }
  if (best_top == std::numeric_limits<int>::max()) {
    return std::nullopt;
  }

  const int right = best.x + size.width;
  std::vector<Segment> raised;
  const auto add = [&raised](const Segment& segment) {
    if (segment.width <= 0) {
      return;
    }
    if (!raised.empty() && raised.back().y == segment.y) {
      raised.back().width += segment.width;
    } else {
      raised.push_back(segment);
    }
  };
  bool added = false;
  for (const Segment& segment : skyline_) {
    const int end = segment.x + segment.width;
    add({segment.x, std::min(end, best.x) - segment.x, segment.y});
    if (!added && end > best.x) {
      add({best.x, size.width, best_top});
      added = true;
    }
    const int begin = std::max(segment.x, right);
    add({begin, end - begin, segment.y});
  }
  skyline_ = std::move(raised);
  height_ = std::max(height_, best_top);
  return best;
}

}  // namespace holdfast::baking
