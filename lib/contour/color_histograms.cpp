#include "contour/color_histograms.hpp"

namespace holdfast {
namespace {

/// Weight of a new frame.
constexpr float kMemory = 0.2F;
/// Pixels beside the contour that belong to neither side.
constexpr int kBetween = 1;
/// Frequency of a colour that was never seen on either side: it tells nothing.
constexpr float kUnseen = 1e-5F;

}  // namespace

void ColorHistograms::clear() {
  object_.assign(kBins, 0);
  background_.assign(kBins, 0);
  share_.assign(kBins, 0.5F);
  count_.assign(kBins, 0);
  known_ = false;
}

bool ColorHistograms::add(std::span<const int> bins, int reach, bool inside, std::vector<float>& frequency) {
  std::fill(count_.begin(), count_.end(), 0.0F);
  const std::size_t line = 2 * static_cast<std::size_t>(reach) + 1;
  const std::size_t first = inside ? 0 : static_cast<std::size_t>(reach + kBetween + 1);
  const std::size_t end = inside ? static_cast<std::size_t>(reach - kBetween) : line;
  float all = 0;
  for (std::size_t start = 0; start + line <= bins.size(); start += line) {
    for (std::size_t i = first; i < end; ++i) {
      const int bin = bins[start + i];
      if (bin < 0) continue;
      count_[static_cast<std::size_t>(bin)] += 1;
      all += 1;
    }
  }
  if (all == 0) return false;
  const float memory = known_ ? kMemory : 1;
  for (std::size_t i = 0; i < kBins; ++i) frequency[i] += memory * (count_[i] / all - frequency[i]);
  return true;
}

void ColorHistograms::learn(std::span<const int> bins, int reach) {
  const bool object = add(bins, reach, true, object_), background = add(bins, reach, false, background_);
  known_ = known_ || (object && background);
  for (std::size_t i = 0; i < kBins; ++i) {
    share_[i] = (object_[i] + kUnseen) / (object_[i] + background_[i] + 2 * kUnseen);
  }
}

}  // namespace holdfast
