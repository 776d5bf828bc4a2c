#pragma once

#include <cstdint>
#include <vector>

#include "contour/color_histograms.hpp"
#include "contour/contour_points.hpp"
#include "image/device_image.hpp"
#include "solve/normal_equations.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// Sums of all lines across a contour, in double. Rows count lines that tell something; residuals are pixels of the
/// level.
struct ContourSums : ConstraintSums {
  Twist outward = Twist::Zero();  ///< what h gains where every edge is found a pixel farther out
  double weighted_distance = 0;   ///< sum of w d
  double lines = 0;               ///< on the frame
  double agreement = 0;  ///< of colours with the contour, mean over the lines whose edge is next to it, at most 1
  double near = 0;       ///< how many those are
};

/// How closely edges are looked for.
struct ContourSearch {
  double step = 1;         ///< pixels of the level between the sixteen places of an edge that are told apart
  double deviation = 1;    ///< pixels that a line's edge is off for reasons of its own, standard deviation
  double far = 0;          ///< pixels of the level at which a line's row weighs half; 0: all weigh fully
  bool by_shares = false;  ///< the edge is where the shares of both sides' colours in the pixels put it
};

/// Constraints from the contour of an object: the line across it at each point, compared with the frame's colours
/// (equations 23 to 28 of docs/math.md). A row a line; lines are summed here in double and in fixed order.
class ContourConstraints {
 public:
  /// Pixels of the level that lines are looked at on either side.
  static constexpr int kReach = 11;
  static constexpr std::size_t kMostLines = 224;

  ContourConstraints(const Device::Impl& device, const std::vector<Level>& levels);

  /// The contour to be used from now on, as drawn at a level.
  void set_points(const DrawnDepth& drawn, int level);
  std::size_t count() const { return points_.size(); }

  /// Uploads what colours tell.
  void set_colors(const ColorHistograms& colors);

  /// Sums when the contour has moved by D since it was drawn. Waits for the device.
  ContourSums evaluate(DeviceImage& image, const Pose& D, const Conditioning& conditioning,
                       const ContourSearch& search);

  /// Calls visit(pixel of the level where the line crosses the contour as drawn, whether its edge is next to it,
  /// whether it tells anything) for every line of the last evaluate().
  template <typename Visit>
  void for_each_line(Visit&& visit) const {
    const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      visit(camera.project(points_[i].p_camera.cast<double>()), lines_[i] == Line::near, lines_[i] != Line::silent);
    }
  }

  /// Adds the colours on both sides of the contour, which must be drawn where it is. Waits for the device.
  void learn(DeviceImage& image, ColorHistograms& colors);

 private:
  void enqueue_points();
  kernel::hf_contour options(const DeviceImage& image, const Pose& D, const Conditioning& conditioning,
                             const ContourSearch& search) const;

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  int level_ = 0;
  ContourScan scan_;
  std::vector<ContourPoint> points_;
  bool uploaded_ = false;
  enum class Line : std::uint8_t { silent, far, near };
  std::vector<Line> lines_;  ///< of the last evaluate(); empty: none since the contour was set
  std::vector<float> sums_;
  std::vector<int> bins_;
  cl::Buffer points_buffer_, share_buffer_, sums_buffer_, bins_buffer_;
  cl::Kernel constraints_, colors_;
};

}  // namespace holdfast
