#include "contour/contour_modality.hpp"

#include <algorithm>
#include <cmath>

#include "holdfast/frame_result.hpp"

namespace holdfast {
namespace {

/// Least side of the object on a level whose contour is still worth following, pixels, and levels above the finest.
constexpr double kLeastSide = 24;
constexpr int kMostCoarser = 2;
constexpr std::size_t kLeastLines = 12;
/// A silhouette is drawn anew when it has moved by more than so many pixels of the level since: by shares, by colours.
constexpr double kRedraw = 0.5, kCoarseRedraw = 1;
/// Lines that count as one observation: their errors are alike.
constexpr double kLinesPerObservation = 12;
/// Common shift of all lines out of the object, pixels, standard deviation: what mixed pixels, blur and light do to
/// every edge alike. It is a parameter of its own, eliminated from the sums.
constexpr double kCommonShift = 0.2;
/// Score from which on the contour is what its residuals say, and reliability that is always left.
constexpr double kReliableScore = 0.8, kLeastReliability = 0.01;
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
                                 ViewTemplate& view, DepthView& shape, DeviceImage& image)
    : levels_(levels), extent_(extent), view_(view), shape_(shape), image_(image), constraints_(device, levels) {}

bool ContourModality::draw(const Pose& T_camera_object, int level, double within_pixels) {
  if (!shape_.draw(T_camera_object, level, within_pixels)) return false;
  if (version_ != shape_.version()) constraints_.set_points(shape_.drawn(), level);
  version_ = shape_.version();
  return true;
}

ContourTerms ContourModality::linearize(const Pose& T_camera_object, int level, const ContourSearch& search) {
  ContourTerms terms;
  if (!draw(T_camera_object, level, search.by_shares ? kRedraw : kCoarseRedraw)) return terms;
  terms.visible_pixels = shape_.visible_pixels();
  terms.found = constraints_.count() >= kLeastLines;
  if (!terms.found) return terms;
  const Pose& T_drawn = shape_.T_drawn();
  const Conditioning conditioning{T_drawn * extent_.p_object_center, extent_.radius};
  const Pose D = renormalized(T_camera_object * T_drawn.inverse());
  terms.sums = constraints_.evaluate(image_, D, conditioning, search);
  // Colours that both sides have, and lines whose edge is elsewhere, put edges where there are none.
  const double reliability = std::clamp(terms.score() / kReliableScore, kLeastReliability, 1.0);
  terms.equations = contour_equations(terms.sums, T_drawn);
  terms.equations *= reliability * reliability;
  return terms;
}

bool ContourModality::learn(const Pose& T_camera_object, int level, ColorHistograms& colors) {
  if (!draw(T_camera_object, level, 0) || constraints_.count() < kLeastLines) return false;
  constraints_.learn(image_, colors);
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
  shape_.start_frame();
  linearize(T_camera_object, finest, kClosestSearch);
  if (shape_.level() < 0) return;
  const Level& first = levels_[0];
  const int side = 1 << finest;
  const auto set = [&](int x, int y, PixelClass value) {
    for (int v = y * side; v < std::min((y + 1) * side, first.height); ++v) {
      for (int u = x * side; u < std::min((x + 1) * side, first.width); ++u) {
        classes[static_cast<std::size_t>(v) * static_cast<std::size_t>(first.width) + static_cast<std::size_t>(u)] =
            static_cast<std::uint8_t>(value);
      }
    }
  };
  const DrawnDepth& drawn = shape_.drawn();
  for (int y = drawn.rect.y; y < drawn.rect.y + drawn.rect.height; ++y) {
    for (int x = drawn.rect.x; x < drawn.rect.x + drawn.rect.width; ++x) {
      if (drawn.at(x, y) < 1.0F) set(x, y, PixelClass::unusable);
    }
  }
  constraints_.for_each_line([&](const Eigen::Vector2d& pixel, bool near, bool telling) {
    const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    if (x < 0 || y < 0) return;
    set(x, y, near ? PixelClass::used : telling ? PixelClass::rejected_magnitude : PixelClass::no_gradient);
  });
}

}  // namespace holdfast
