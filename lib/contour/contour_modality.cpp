#include "contour/contour_modality.hpp"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"
#include "holdfast/frame_result.hpp"

namespace holdfast {
namespace {

/// Least side of the object on a level whose contour is still worth following, pixels, and levels above the finest.
constexpr double kLeastSide = 24;
constexpr int kMostCoarser = 2;
constexpr std::size_t kLeastLines = 12;
/// A silhouette is drawn anew when it has moved by more than so many pixels of the level since: by shares, by colours.
constexpr double kRedraw = 0.25, kCoarseRedraw = 1;
/// Lines that count as one observation: their errors are alike.
constexpr double kLinesPerObservation = 12;
/// Common shift of all lines out of the object, pixels, standard deviation: what mixed pixels, blur and light do to
/// every edge alike. It is a parameter of its own, eliminated from the sums.
constexpr double kCommonShift = 0.2;
/// Least variance of a line, square pixels.
constexpr double kLeastVariance = 1e-4;

}  // namespace

const ContourSearch kCoarseSearch{.step = 1, .deviation = 1, .far = 2, .by_shares = false};
const ContourSearch kCloseSearch{.step = 0.5, .deviation = 0.5, .far = 2, .by_shares = false};
const ContourSearch kClosestSearch{.step = 0.5, .deviation = 0.5, .far = 1, .by_shares = true};

NormalEquations contour_equations(const ContourSums& sums, const Pose& T_drawn) {
  if (sums.rows < 1) return {};
  const double variance = std::max(kLeastVariance, sums.weighted_square / std::max(1.0, sums.rows - 6));
  const double unit = kLinesPerObservation * variance;
  const double shift_information = sums.weight / unit + 1 / (kCommonShift * kCommonShift);
  const Twist coupling = sums.outward / unit;
  const double shift_score = sums.weighted_distance / unit;
  return NormalEquations::from_camera_axes(sums.A / unit - coupling * coupling.transpose() / shift_information,
                                           sums.h / unit - coupling * shift_score / shift_information, T_drawn);
}

ContourModality::ContourModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                                 ViewTemplate& view, DeviceImage& image)
    : levels_(levels), extent_(extent), view_(view), image_(image), constraints_(device, levels) {
  depth_.resize(levels[0].elements);
}

bool ContourModality::draw(const Pose& T_camera_object, int level_index) {
  level_drawn_ = -1;
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return false;
  const Rect wanted = grown({object.x >> level_index, object.y >> level_index, (object.width >> level_index) + 2,
                             (object.height >> level_index) + 2},
                            ContourConstraints::kReach + 4);
  const Rect rect = aligned(wanted, 4, level.padded_width, level.padded_height);
  if (rect.empty()) return false;
  {
    const Stopwatch watch(render_ms_);
    drawn_.range = view_.renderer().render(T_camera_object, level.camera, rect, {nullptr, depth_.data(), rect.width});
  }
  drawn_.depth = depth_.data();
  drawn_.rect = rect;
  T_drawn_ = T_camera_object;
  level_drawn_ = level_index;
  constraints_.set_points(drawn_, level_index);
  return true;
}

ContourTerms ContourModality::linearize(const Pose& T_camera_object, int level, const ContourSearch& search) {
  ContourTerms terms;
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  if (level != level_drawn_ ||
      corner_motion(extent_, camera, T_drawn_, T_camera_object) > (search.by_shares ? kRedraw : kCoarseRedraw)) {
    if (!draw(T_camera_object, level)) return terms;
  }
  terms.visible_pixels = visible_pixels();
  terms.found = constraints_.count() >= kLeastLines;
  if (!terms.found) return terms;
  const Conditioning conditioning{T_drawn_ * extent_.p_object_center, extent_.radius};
  const Pose D = renormalized(T_camera_object * T_drawn_.inverse());
  terms.sums = constraints_.evaluate(image_, D, conditioning, search);
  terms.equations = contour_equations(terms.sums, T_drawn_);
  return terms;
}

bool ContourModality::learn(const Pose& T_camera_object, int finest, ColorHistograms& colors) {
  const int level = std::min(finest + 1, coarsest(T_camera_object, finest));
  if (!draw(T_camera_object, level) || constraints_.count() < kLeastLines) return false;
  constraints_.learn(image_, Pose::Identity(), {T_drawn_ * extent_.p_object_center, extent_.radius}, colors);
  return true;
}

int ContourModality::coarsest(const Pose& T_camera_object, int finest) const {
  const Rect object = view_.bounds(T_camera_object);
  const double side = std::min(object.width, object.height);
  const int last = std::min(static_cast<int>(levels_.size()) - 1, finest + kMostCoarser);
  int level = finest;
  while (level < last && side / (1 << (level + 1)) >= kLeastSide) ++level;
  return level;
}

void ContourModality::classify(const Pose& T_camera_object, int finest, std::vector<std::uint8_t>& classes) {
  level_drawn_ = -1;
  linearize(T_camera_object, finest, kClosestSearch);
  if (level_drawn_ < 0) return;
  const Level& first = levels_[0];
  const int side = 1 << level_drawn_;
  const auto set = [&](int x, int y, PixelClass value) {
    for (int v = y * side; v < std::min((y + 1) * side, first.height); ++v) {
      for (int u = x * side; u < std::min((x + 1) * side, first.width); ++u) {
        classes[static_cast<std::size_t>(v) * static_cast<std::size_t>(first.width) + static_cast<std::size_t>(u)] =
            static_cast<std::uint8_t>(value);
      }
    }
  };
  const Rect& rect = drawn_.rect;
  for (int y = 0; y < rect.height; ++y) {
    for (int x = 0; x < rect.width; ++x) {
      if (drawn_.depth[y * rect.width + x] < 1.0F) set(rect.x + x, rect.y + y, PixelClass::unusable);
    }
  }
  constraints_.for_each_line([&](const Eigen::Vector2d& pixel, bool near, bool telling) {
    const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    if (x < 0 || y < 0) return;
    set(x, y, near ? PixelClass::used : telling ? PixelClass::rejected_magnitude : PixelClass::no_gradient);
  });
}

int ContourModality::visible_pixels() const {
  if (level_drawn_ < 0) return 0;
  const Level& level = levels_[static_cast<std::size_t>(level_drawn_)];
  int count = 0;
  for (int y = 0; y < drawn_.rect.height && drawn_.rect.y + y < level.height; ++y) {
    const float* row = drawn_.depth + static_cast<std::ptrdiff_t>(y) * drawn_.rect.width;
    const int width = std::min(drawn_.rect.width, level.width - drawn_.rect.x);
    count += static_cast<int>(std::count_if(row, row + width, [](float depth) { return depth < 1.0F; }));
  }
  return count << (2 * level_drawn_);
}

}  // namespace holdfast
