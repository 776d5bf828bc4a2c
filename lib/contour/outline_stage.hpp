#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/corner_motion.hpp"
#include "contour/object_colors.hpp"
#include "contour/outline_constraints.hpp"
#include "image/device_image.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// A pose that an object's outline leads to.
struct OutlineEstimate {
  Pose T_camera_object = Pose::Identity();
  bool solved = false;
  OutlineSums sums;
  double score = -1;                      ///< agreement of the colours, times the share of lines whose edge is there
  Matrix6 covariance = Matrix6::Zero();   ///< conditioned as the sums are
  Matrix6 information = Matrix6::Zero();  ///< of the outline alone, without where it was looked for; conditioned
  /// Motions that turn the object without its outline showing it, conditioned, a column each: of a can about its axis.
  Eigen::Matrix<double, 6, 3> hidden_turns = Eigen::Matrix<double, 6, 3>::Zero();
  int hidden_turn_count = 0;
  Conditioning conditioning;  ///< of the sums
  int visible_pixels = 0;     ///< pixels of the frame inside the silhouette
};

/// Takes from `information` all that it tells of this motion; of others it tells as much as before where this one is
/// free.
void forget(Matrix6& information, const Twist& motion);

/// Whether the outline tells next to nothing of this motion, conditioned: less than noise may make of it.
bool hides(const OutlineEstimate& outline, const Twist& motion);

/// Follows the outline of an object through a frame: draws its silhouette, looks for its edges along lines across it,
/// moves it there, coarse to fine, first by what colours belong to it, then by how much of it each pixel at the edge
/// shows.
class OutlineStage {
 public:
  /// Milliseconds and solved systems since they were last taken.
  struct Effort {
    double render_ms = 0, lines_ms = 0, solve_ms = 0;
    int solved_systems = 0;
  };

  /// Draws with `view`'s renderer, looks at `image`.
  OutlineStage(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent, ViewTemplate& view,
               DeviceImage& image);

  /// Forgets all colours.
  void clear() { colors_.clear(); }
  bool colors_known() const { return colors_.known(); }
  const ObjectColors& colors() const { return colors_; }
  void set_colors(const ObjectColors& colors);

  /// Learns the colours on both sides of the outline at this pose; little by little once they are known.
  void learn(const Pose& T_camera_object, int finest);

  /// Nowhere solved where the object is out of view or too little of its outline is seen. `deviation`: how far from the
  /// start the object may be (object radii and radians, standard deviation); 0: as far as its outline leads.
  OutlineEstimate estimate(const Pose& T_start, int finest, double deviation = 0);

  /// The same from within about a pixel.
  OutlineEstimate estimate_nearby(const Pose& T_start, int finest);

  /// Pixels of the frame around the object that estimate() looks at, at most.
  int margin() const { return (OutlineConstraints::kReach + 4) << (levels_.size() - 1); }

  Effort take_effort() { return std::exchange(effort_, {}); }

  /// A byte a pixel of the frame, values of PixelClass: the silhouette at a pose, and what becomes of its outline.
  void classify(const Pose& T_camera_object, int finest, std::vector<std::uint8_t>& classes);

 private:
  struct Expectation {
    Pose T_camera_object = Pose::Identity();
    double deviation = 0;  ///< object radii and radians; 0: nothing is expected
  };

  bool draw(const Pose& T_camera_object, int level);
  Conditioning conditioning() const { return {T_drawn_ * extent_.p_object_center, extent_.radius}; }
  /// Pixels of the frame inside the silhouette drawn last.
  int visible_pixels() const;
  int coarsest(const Pose& T_camera_object, int finest) const;
  /// By which corners move between two motions of the view drawn, pixels of the level.
  double motion(int level, const Pose& D_from, const Pose& D_to) const;
  /// Some solutions on a level; draws anew where the outline has moved since.
  bool approach(OutlineEstimate& estimate, int level, const OutlineSearch& search, const Expectation& expected);
  /// The lines' sums with what is expected of the pose counted in.
  ConstraintSums with_expectation(ConstraintSums sums, const Expectation& expected) const;
  /// What the outline says where the searches led.
  void measure(OutlineEstimate& estimate, const OutlineSearch& search);
  /// Takes from the information what it says of turns that hardly show.
  static void forget_hidden_turns(OutlineEstimate& estimate);

  const std::vector<Level>& levels_;
  Extent extent_;
  ViewTemplate& view_;
  DeviceImage& image_;
  OutlineConstraints constraints_;
  ObjectColors colors_;
  std::vector<float> depth_;
  DrawnDepth drawn_;
  Pose T_drawn_ = Pose::Identity();
  int level_drawn_ = -1;       ///< none
  Pose D_ = Pose::Identity();  ///< how the outline has moved since
  Effort effort_;
};

}  // namespace holdfast
