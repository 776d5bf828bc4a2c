#pragma once

#include <cstdint>
#include <vector>

#include "base/corner_motion.hpp"
#include "contour/color_histograms.hpp"
#include "contour/contour_constraints.hpp"
#include "image/depth_view.hpp"
#include "image/device_image.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {

/// What the contour says of a pose.
struct ContourTerms {
  bool found = false;  ///< enough of the contour is in the picture
  ContourSums sums;
  NormalEquations equations;
  int visible_pixels = 0;  ///< pixels of the frame inside the silhouette

  /// Agreement of the colours, times the share of lines whose edge is next to the contour: at most 1.
  double score() const { return sums.agreement * sums.near / std::max(1.0, sums.lines); }
};

/// The contour as a modality: draws the silhouette at a pose, looks along lines across it for the edge between the
/// object's colours and the background's, and turns each into a row (equations 23 to 28 of docs/math.md). Keeps no
/// pose: the lines are a cache of what `shape` has drawn of the frame at hand.
class ContourModality {
 public:
  /// Draws with `shape`, looks at `image`.
  ContourModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                  ViewTemplate& view, DepthView& shape, DeviceImage& image);

  /// The colours that lines are compared with from now on.
  void use_colors(const ColorHistograms& colors) { constraints_.set_colors(colors); }

  /// Rows and their normal equations at this pose on a level.
  ContourTerms linearize(const Pose& T_camera_object, int level, const ContourSearch& search);

  /// Adds the colours on both sides of the contour at this pose to `colors`, as seen on a level. False where the
  /// contour is not in view.
  bool learn(const Pose& T_camera_object, int level, ColorHistograms& colors);

  /// The coarsest level on which the contour is worth following.
  int coarsest(const Pose& T_camera_object, int finest) const;

  /// Pixels of the frame around the object that lines may reach.
  int margin() const { return (ContourConstraints::kReach + 4) << (levels_.size() - 1); }

  /// A byte a pixel of the frame, values of PixelClass: the silhouette at a pose, and what becomes of its contour.
  void classify(const Pose& T_camera_object, int finest, std::vector<std::uint8_t>& classes);

 private:
  bool draw(const Pose& T_camera_object, int level, double within_pixels);

  const std::vector<Level>& levels_;
  Extent extent_;
  ViewTemplate& view_;
  DepthView& shape_;
  DeviceImage& image_;
  ContourConstraints constraints_;
  int version_ = -1;  ///< of what is drawn, that the lines are of
};

/// Searches from coarse levels to the last iterations on the finest: by colours alone, closer, by shares of colours.
extern const ContourSearch kCoarseSearch, kCloseSearch, kClosestSearch;

/// Normal equations in information units of a contour's sums, made at the pose T_drawn.
NormalEquations contour_equations(const ContourSums& sums, const Pose& T_drawn);

}  // namespace holdfast
