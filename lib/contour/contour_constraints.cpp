#include "contour/contour_constraints.hpp"

#include <cmath>

namespace holdfast {
namespace {

/// Half the pixels that an edge is blurred over, and how far colours are trusted.
constexpr double kSoftness = 0.6, kTrust = 0.43;
/// Pixels at the edge that show shares of both sides, and those beyond them that show what each side looks like.
constexpr int kBeside = 2, kAround = 6;
/// Pixels of the level within which a line's edge is next to the contour.
constexpr double kNear = 1.5;
/// 1 / square pixels, of a line that tells something.
constexpr double kLeastInformation = 0.05;
constexpr std::size_t kLine = 2 * ContourConstraints::kReach + 1;

}  // namespace

ContourConstraints::ContourConstraints(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device), levels_(levels) {
  points_.reserve(kMostLines);
  const auto side = static_cast<std::size_t>(levels[0].width + levels[0].height);
  scan_.pixels.reserve(8 * side);  // of a contour that crosses the picture as often
  scan_.marks.reserve(side);
  lines_.reserve(kMostLines);
  sums_.resize(kMostLines * HF_CONTOUR_SUMS);
  bins_.resize(kMostLines * kLine);
  points_buffer_ = device.zeroed_buffer(kMostLines * sizeof(ContourPoint));
  share_buffer_ = device.zeroed_buffer(ColorHistograms::kBins * sizeof(float));
  sums_buffer_ = device.zeroed_buffer(sums_.size() * sizeof(float));
  bins_buffer_ = device.zeroed_buffer(bins_.size() * sizeof(int));
  constraints_ = device.kernel("contour_constraints");
  colors_ = device.kernel("contour_colors");
}

void ContourConstraints::set_points(const DrawnDepth& drawn, int level) {
  level_ = level;
  lines_.clear();
  contour_points(drawn, levels_[static_cast<std::size_t>(level)].camera, kMostLines, kReach, scan_, points_);
  uploaded_ = false;
}

void ContourConstraints::enqueue_points() {
  if (uploaded_) return;
  device_.queue.enqueueWriteBuffer(points_buffer_, CL_FALSE, 0, points_.size() * sizeof(ContourPoint), points_.data());
  uploaded_ = true;
}

void ContourConstraints::set_colors(const ColorHistograms& colors) {
  device_.queue.enqueueWriteBuffer(share_buffer_, CL_TRUE, 0, colors.share().size() * sizeof(float),
                                   colors.share().data());
}

kernel::hf_contour ContourConstraints::options(const DeviceImage& image, const Pose& D,
                                               const Conditioning& conditioning, const ContourSearch& search) const {
  kernel::hf_contour o{};
  to_rows(D, o.d);
  for (int i = 0; i < 3; ++i) o.center[i] = static_cast<float>(conditioning.p_camera_center(i));
  o.radius = static_cast<float>(conditioning.radius);
  set_intrinsics(o, levels_[static_cast<std::size_t>(level_)].camera);
  o.region = to_kernel(image.uploaded(level_));
  o.count = static_cast<int>(points_.size());
  o.reach = kReach;
  o.step = static_cast<float>(search.step);
  o.softness2 = static_cast<float>(kSoftness * kSoftness);
  o.trust = static_cast<float>(kTrust);
  o.variance = static_cast<float>(search.deviation * search.deviation);
  o.by_shares = search.by_shares ? 1 : 0;
  o.beside = kBeside;
  o.around = kAround;
  o.far2 = static_cast<float>(search.far * search.far);
  return o;
}

ContourSums ContourConstraints::evaluate(DeviceImage& image, const Pose& D, const Conditioning& conditioning,
                                         const ContourSearch& search) {
  ContourSums sums;
  image.enqueue_pixels(level_);
  enqueue_points();
  set_arguments(constraints_, image.pixels(level_), levels_[static_cast<std::size_t>(level_)].layout, points_buffer_,
                options(image, D, conditioning, search), share_buffer_, sums_buffer_);
  device_.enqueue_items(constraints_, points_.size());
  device_.queue.enqueueReadBuffer(sums_buffer_, CL_TRUE, 0, points_.size() * HF_CONTOUR_SUMS * sizeof(float),
                                  sums_.data());
  lines_.assign(points_.size(), Line::silent);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const float* line = sums_.data() + i * HF_CONTOUR_SUMS;
    if (line[HF_CONTOUR_AGREEMENT] == 0.0F && line[HF_CONTOUR_INFORMATION] == 0.0F) continue;
    ++sums.lines;
    if (static_cast<double>(line[HF_CONTOUR_INFORMATION]) < kLeastInformation) continue;
    const bool near = std::abs(static_cast<double>(line[HF_CONTOUR_DISTANCE])) < kNear;
    lines_[i] = near ? Line::near : Line::far;
    if (near) {
      ++sums.near;
      sums.agreement += static_cast<double>(line[HF_CONTOUR_AGREEMENT]);
    }
    ++sums.rows;
    std::size_t n = HF_SUM_A;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) sums.A(a, b) += static_cast<double>(line[n++]);
      sums.h(a) += static_cast<double>(line[HF_SUM_H + a]);
      sums.outward(a) += static_cast<double>(line[HF_CONTOUR_OUTWARD + a]);
    }
    sums.weighted_square += static_cast<double>(line[HF_CONTOUR_WRR]);
    sums.weight += static_cast<double>(line[HF_CONTOUR_W]);
    sums.weighted_distance += static_cast<double>(line[HF_CONTOUR_W]) * static_cast<double>(line[HF_CONTOUR_DISTANCE]);
  }
  if (sums.near > 0) sums.agreement /= sums.near;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < a; ++b) sums.A(a, b) = sums.A(b, a);
  }
  return sums;
}

void ContourConstraints::learn(DeviceImage& image, ColorHistograms& colors) {
  image.enqueue_pixels(level_);
  enqueue_points();
  set_arguments(colors_, image.pixels(level_), levels_[static_cast<std::size_t>(level_)].layout, points_buffer_,
                options(image, Pose::Identity(), {}, {}), bins_buffer_);
  device_.enqueue_items(colors_, points_.size());
  const std::size_t count = points_.size() * kLine;
  device_.queue.enqueueReadBuffer(bins_buffer_, CL_TRUE, 0, count * sizeof(int), bins_.data());
  colors.learn({bins_.data(), count}, kReach);
}

}  // namespace holdfast
