#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "holdfast/io.hpp"
#include "io/focal_check.hpp"

namespace holdfast::io {
namespace {

constexpr double kSmallest = 1e-3;    // metres
constexpr double kLargest = 30;       // metres: lorries and boats are tracked too
constexpr double kLargestSeen = 100;  // metres, of what a camera sees whole at this pose: an aeroplane
/// Distances from its origin, in sizes, at which a model is told by single precision to a thousandth of its size.
constexpr double kFarthestOrigin = 1e4;
/// Objects worth tracking are about as long as a hand to an arm; of several possible units the likely one is that which
/// brings the size nearest to this.
constexpr double kTypical = 0.2;  // metres
/// The object's apparent size in picture widths. A thousandfold error is out of this range whatever the framing, and
/// inches are where the object is wider than an eighth of the picture.
constexpr double kApparentSmallest = 1.0 / 300;
constexpr double kApparentLargest = 5;
constexpr double kApparentTypical = 0.15;

struct Unit {
  const char* name;
  const char* scale;  ///< to metres; two where the unit is one of two
  double metres;
};

/// Centimetres and inches are too near each other for a size to tell which.
constexpr Unit kSmallUnits[] = {
    {"centimetres or inches", "0.01 or 0.0254", 0.016}, {"millimetres", "0.001", 1e-3}, {"micrometres", "1e-06", 1e-6}};

/// Largest side of the axis-aligned bounding box.
double extent(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& position : mesh.positions) {
    box.extend(position.cast<double>());
  }
  return box.isEmpty() ? 0 : box.sizes().maxCoeff();
}

/// The unit that brings a size nearest to what is typical.
Unit likely_unit(double size, double typical) {
  return *std::min_element(std::begin(kSmallUnits), std::end(kSmallUnits), [=](const Unit& a, const Unit& b) {
    return std::abs(std::log(size * a.metres / typical)) < std::abs(std::log(size * b.metres / typical));
  });
}

/// How wide the object is in the picture, picture widths; nothing where it is not known.
std::optional<double> apparent_size(double size, const Mesh& mesh, const std::optional<Pose>& T_camera_object,
                                    const std::optional<Camera>& camera) {
  const double picture = camera ? std::max({camera->width * 1.0, camera->height * 1.0, 2 * camera->cx}) : 0;
  if (!T_camera_object || !(picture > 0) || focal_warning(*camera)) return std::nullopt;
  const double distance = (*T_camera_object * mesh.center()).z();
  if (!(distance > 0)) return std::nullopt;
  return std::max(camera->fx, camera->fy) * size / distance / picture;
}

}  // namespace

std::optional<std::string> unit_warning(const Mesh& mesh, const std::optional<Pose>& T_camera_object,
                                        const std::optional<Camera>& camera) {
  const double size = extent(mesh);
  if (!(size > 0)) {
    return std::nullopt;
  }
  const std::optional<double> apparent = apparent_size(size, mesh, T_camera_object, camera);
  const bool plausible = apparent && *apparent > kApparentSmallest && *apparent < kApparentLargest;
  if (size > kLargest && !(plausible && size < kLargestSeen)) {
    const Unit unit = likely_unit(size, kTypical);
    return fmt::format(
        "the object is {:.3g} m across: are its coordinates {}? scale it by {} (times the scale that was given, if "
        "any)",
        size, unit.name, unit.scale);
  }
  if (size < kSmallest) {
    return fmt::format(
        "the object is {:.3g} mm across: was it in metres already when a scale was applied, or are its coordinates "
        "kilometres? multiply the scale by 1000",
        size * 1e3);
  }
  const double away = mesh.center().norm();
  if (away > kFarthestOrigin * size) {
    return fmt::format(
        "the model lies {:.3g} m from its origin, {:.0e} times its size: so far away its coordinates are coarse "
        "numbers; move it to its origin",
        away, away / size);
  }
  if (!apparent) {
    return std::nullopt;
  }
  const double distance = (*T_camera_object * mesh.center()).z();
  if (*apparent < kApparentSmallest) {
    return fmt::format(
        "the object is {:.3g} m across but {:.4g} m away, too small to see: are the pose's translations millimetres "
        "(divide them by 1000), or was the model scaled twice?",
        size, distance);
  }
  if (*apparent > kApparentLargest) {
    const Unit unit = likely_unit(*apparent, kApparentTypical);
    return fmt::format(
        "the object is {:.3g} m across but only {:.3g} m away, {:.0f} times as wide as the picture: are its "
        "coordinates {}? scale it by {} (times the scale that was given, if any)",
        size, distance, *apparent, unit.name, unit.scale);
  }
  return std::nullopt;
}

}  // namespace holdfast::io
