#include "texture/print_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "image/level_rect.hpp"

namespace holdfast {
namespace {

/// Gradient of a print, intensity a pixel: several times what shading and fine grain have after the blur.
constexpr double kStrong = 0.03;
/// Share of the view that has such where it is printed: labels of little contrast have 0.04, clay and metal less than
/// 0.01, prints 0.28 or more. Fewer pixels than this are no print either.
constexpr double kPrinted = 0.1;
constexpr int kFewest = 100;
/// Correlation that shows the print: another has 0.0 to 0.35, the right one 0.7 to 0.95, blurred and noisy ones
/// included.
constexpr double kLeastCorrelation = 0.4;

}  // namespace

bool PrintAgreement::missing() const {
  return pixels >= std::max<double>(kFewest, kPrinted * usable) && correlation < kLeastCorrelation;
}

PrintAgreement print_agreement(const Device::Impl& device, const ViewTemplate& view, const DeviceImage& image,
                               const Level& level) {
  const ViewTemplate::Planes& planes = view.planes(level.index);
  const Rect rect = planes.drawn();
  if (rect.empty()) return {};
  const auto w = static_cast<std::size_t>(rect.width), h = static_cast<std::size_t>(rect.height);
  std::vector<unsigned char> usable(w * h);
  read_rect(device, planes.usable, level, rect, 1, usable.data());
  std::vector<float> frame(HF_PIXEL * w * h);
  read_rect(device, image.blurred(level.index), level, rect, HF_PIXEL * sizeof(float), frame.data());
  std::vector<float> dx(HF_CHANNELS * w * h), dy(HF_CHANNELS * w * h);
  for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
    read_rect(device, planes.dx, level, rect, sizeof(float), dx.data() + c * w * h, c * level.elements);
    read_rect(device, planes.dy, level, rect, sizeof(float), dy.data() + c * w * h, c * level.elements);
  }
  const Rect& valid = image.valid(level.index);
  PrintAgreement result;
  double both = 0, of_view = 0, of_frame = 0;
  for (int y = 1; y + 1 < rect.height; ++y) {
    for (int x = 1; x + 1 < rect.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x);
      const int px = rect.x + x, py = rect.y + y;
      if (usable[i] != HF_USED || px < valid.x || py < valid.y || px >= valid.x + valid.width ||
          py >= valid.y + valid.height) {
        continue;
      }
      ++result.usable;
      bool strong = false;
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        strong = strong || std::hypot(dx[c * w * h + i], dy[c * w * h + i]) > kStrong;
      }
      if (!strong) continue;
      ++result.pixels;
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        const double vx = static_cast<double>(dx[c * w * h + i]), vy = static_cast<double>(dy[c * w * h + i]);
        const double ix = 0.5 * static_cast<double>(frame[HF_PIXEL * (i + 1) + c] - frame[HF_PIXEL * (i - 1) + c]);
        const double iy = 0.5 * static_cast<double>(frame[HF_PIXEL * (i + w) + c] - frame[HF_PIXEL * (i - w) + c]);
        both += vx * ix + vy * iy;
        of_view += vx * vx + vy * vy;
        of_frame += ix * ix + iy * iy;
      }
    }
  }
  if (of_view > 0 && of_frame > 0) result.correlation = both / std::sqrt(of_view * of_frame);
  return result;
}

}  // namespace holdfast
