#pragma once

#include <cstdint>
#include <vector>

#include "contour/object_colors.hpp"
#include "contour/outline_points.hpp"
#include "image/device_image.hpp"
#include "solve/solver.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// Sums of all lines across an outline, in double. Rows count lines that tell something; residuals are pixels of the
/// level.
struct OutlineSums : ConstraintSums {
  Twist outward = Twist::Zero();  ///< what h gains where every edge is found a pixel farther out
  double lines = 0;               ///< on the frame
  double agreement = 0;  ///< of colours with the outline, mean over the lines whose edge is next to it, at most 1
  double near = 0;       ///< how many those are
};

/// How closely edges are looked for.
struct OutlineSearch {
  double step = 1;         ///< pixels of the level between the sixteen places of an edge that are told apart
  double deviation = 1;    ///< pixels that a line's edge is off for reasons of its own, standard deviation
  double far = 0;          ///< pixels of the level at which a line's row weighs half; 0: all weigh fully
  bool by_shares = false;  ///< the edge is where the shares of both sides' colours in the pixels put it
};

/// Constraints from the outline of an object: the line across it at each point, compared with the frame's colours
/// (equations 23 to 28 of docs/math.md). A row a line; lines are summed here in double and in fixed order.
class OutlineConstraints {
 public:
  /// Pixels of the level that lines are looked at on either side.
  static constexpr int kReach = 11;
  static constexpr std::size_t kMostLines = 224;

  OutlineConstraints(const Device::Impl& device, const std::vector<Level>& levels);

  /// The outline to be used from now on, as drawn at a level.
  void set_points(const DrawnDepth& drawn, int level);
  std::size_t count() const { return points_.size(); }

  /// Uploads what colours tell.
  void set_colors(const ObjectColors& colors);

  /// Sums when the outline has moved by D since it was drawn. Waits for the device.
  OutlineSums evaluate(DeviceImage& image, const Pose& D, const Conditioning& conditioning,
                       const OutlineSearch& search);

  /// Calls visit(pixel of the level where the line crosses the outline as drawn, whether its edge is next to it,
  /// whether it tells anything) for every line of the last evaluate().
  template <typename Visit>
  void for_each_line(Visit&& visit) const {
    const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      visit(camera.project(points_[i].p_camera.cast<double>()), lines_[i] == Line::near, lines_[i] != Line::silent);
    }
  }

  /// Adds the colours on both sides of the outline when it has moved by D. Waits for the device.
  void learn(DeviceImage& image, const Pose& D, const Conditioning& conditioning, ObjectColors& colors);

 private:
  kernel::hf_outline options(const DeviceImage& image, const Pose& D, const Conditioning& conditioning,
                             const OutlineSearch& search) const;
  void enqueue(cl::Kernel& kernel);

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  int level_ = 0;
  std::vector<OutlinePoint> points_;
  enum class Line : std::uint8_t { silent, far, near };
  std::vector<Line> lines_;  ///< of the last evaluate(); empty: none since the outline was set
  std::vector<float> sums_;
  std::vector<int> bins_;
  cl::Buffer points_buffer_, share_buffer_, sums_buffer_, bins_buffer_;
  cl::Kernel constraints_, colors_;
};

}  // namespace holdfast
