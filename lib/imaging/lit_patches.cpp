#include "imaging/lit_patches.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Pixels of the object's tiles that are looked at.
constexpr double kMostPixels = 4000;
/// Brightness of texture below which the frame's tells nothing of light.
constexpr double kDarkest = 0.05;
/// Of how many pixels gradients are compared, and across how many of them.
constexpr std::size_t kGradientsEvery = 4;
constexpr int kReach = 3;

/// Every how manieth row and column of a region to look at.
int step_in(double pixels) { return std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMostPixels)))); }

/// In the rows that are read of any region of a level: step_in() times as few as the region has, or, rounded to rows
/// that have samples, 2/3 of that.
std::size_t most_pixels(const Level& level) {
  const double width = level.tiles_x() * HF_TILE, rows = level.tiles_y() * HF_TILE;
  return static_cast<std::size_t>(1.5 * std::sqrt(kMostPixels * width * rows) + 2 * width);
}

}  // namespace

LitPatches::LitPatches(const Device::Impl& device, const std::vector<Level>& levels)
    : device_(device),
      levels_(levels),
      most_(most_pixels(levels[0])),
      planes_(device.host_memory(4 * HF_CHANNELS * most_ * sizeof(float))),
      classes_(device.host_memory(most_)) {
  patches_.reserve(static_cast<std::size_t>(kMostPixels));
}

std::span<const LitPatch> LitPatches::read(const ViewTemplate& view, const FlowConstraints& samples, int level_index,
                                           int every, const Photometry& photometry, const DrawnLight& drawn) {
  const Shading& shading = drawn.shading;
  patches_.clear();
  texture_ = light_ = 0;
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const ViewTemplate::Planes& planes = view.planes(level_index);
  const kernel::hf_rect& tiles = planes.tiles;
  const int step = step_in(static_cast<double>(tiles.width * tiles.height) * (HF_TILE * HF_TILE));
  // Rows that were not looked at have samples of an earlier frame.
  const int step_y = every * std::max(1, (step + every / 2) / every);
  const int first_x = tiles.x * HF_TILE, first_y = (tiles.y * HF_TILE + step_y - 1) / step_y * step_y;
  const int end_y = (tiles.y + tiles.height) * HF_TILE;
  if (first_y >= end_y || tiles.width == 0) return patches_;

  const auto width = static_cast<std::size_t>(tiles.width * HF_TILE);
  const auto rows = static_cast<std::size_t>((end_y - first_y + step_y - 1) / step_y);
  const auto pitch = static_cast<std::size_t>(step_y) * static_cast<std::size_t>(level.layout.stride);
  const auto first = static_cast<std::size_t>(level.layout.origin + first_y * level.layout.stride + first_x);
  const auto read = [&](const cl::Buffer& buffer, std::size_t plane, auto* to, cl_bool wait) {
    const std::size_t size = sizeof(*to), start = plane * level.elements + first;
    device_.queue.enqueueReadBufferRect(buffer, wait, {start % pitch * size, start / pitch, 0}, {0, 0, 0},
                                        {width * size, rows, 1}, pitch * size, 0, width * size, 0, to);
    return to;
  };
  std::array<const float*, HF_CHANNELS> view_value, view_dx, view_dy, frame_value;
  auto* plane = planes_.as<float>();
  for (std::size_t c = 0; c < HF_CHANNELS; ++c, plane += 4 * most_) {
    view_value[c] = read(planes.value, c, plane, CL_FALSE);
    view_dx[c] = read(planes.dx, c, plane + most_, CL_FALSE);
    view_dy[c] = read(planes.dy, c, plane + 2 * most_, CL_FALSE);
    frame_value[c] = read(samples.samples(), c, plane + 3 * most_, CL_FALSE);
  }
  const auto* classes = read(samples.classes(level_index), 0, classes_.as<std::uint8_t>(), CL_TRUE);

  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < width; column += static_cast<std::size_t>(step)) {
      const std::size_t i = row * width + column;
      if (classes[i] < HF_NO_GRADIENT) continue;
      double texture = 0, frame = 0;
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        const auto in_view = static_cast<double>(view_value[c][i]), in_frame = static_cast<double>(frame_value[c][i]);
        if (in_frame >= kSaturated) continue;  // clipped, perhaps: tells of light no more than of motion
        texture += photometry.gain(static_cast<int>(c)) * in_view;
        frame += in_frame;
      }
      if (texture < kDarkest) continue;
      const int x = first_x + static_cast<int>(column), y = first_y + static_cast<int>(row) * step_y;
      const auto normal = view.normal_at(x, y);
      if (!normal) continue;
      const double light = drawn.lit ? drawn.shading.of(*normal) : 1;
      // The quotient of what is dark is the less sure.
      patches_.push_back({*normal, light * frame / texture, texture * texture});
      if (patches_.size() % kGradientsEvery != 0) continue;
      // Of the logarithm, over some pixels, since a mesh turns from triangle to triangle.
      const auto left = view.normal_at(x - kReach, y), right = view.normal_at(x + kReach, y),
                 up = view.normal_at(x, y - kReach), down = view.normal_at(x, y + kReach);
      if (!left || !right || !up || !down) continue;
      const double light_x = std::log(shading.of(*right) / shading.of(*left)) / (2 * kReach);
      const double light_y = std::log(shading.of(*down) / shading.of(*up)) / (2 * kReach);
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        const auto in_view = static_cast<double>(view_value[c][i]);
        const double texture_x = static_cast<double>(view_dx[c][i]) - (drawn.lit ? in_view * light_x : 0);
        const double texture_y = static_cast<double>(view_dy[c][i]) - (drawn.lit ? in_view * light_y : 0);
        texture_ += texture_x * texture_x + texture_y * texture_y;
        light_ += in_view * in_view * (light_x * light_x + light_y * light_y);
      }
    }
  }
  return patches_;
}

}  // namespace holdfast
