#pragma once

#include "base/tuning.hpp"
#include "contour/contour_modality.hpp"
#include "edges/edge_modality.hpp"
#include "holdfast/frame_result.hpp"
#include "image/device_image.hpp"
#include "image/view_template.hpp"
#include "imaging/exposure_estimator.hpp"
#include "judge/alignment.hpp"
#include "motion/motion_filter.hpp"
#include "recovery/shift_search.hpp"
#include "texture/texture_modality.hpp"
#include "tracker/tracking_state.hpp"

namespace holdfast {

/// The levels and effort of one alignment.
struct AlignmentPlan {
  int coarsest = 0, finest = 0;
  bool shift_search = false;  ///< before the first iteration, on the coarsest level
  int redraws = 1;            ///< on the finest level, where the pose has moved away from the view
  int light_from = -1;        ///< coarser level whose view's gain and bias are begun with; -1: the object's
  double converged = 0.05;    ///< steps of so many pixels end it
  double most_motion = 1e9;   ///< pixels of the frame, beyond which the alignment gives up
  bool expected = true;       ///< the motion prior counts; otherwise a weak one about the start
  bool measure = true;        ///< the covariance is wanted
  bool still = false;         ///< looks at the start, does not move
  bool all = false;           ///< no modality is spared
  bool contour = true;        ///< the contour is asked where it can change the pose
};

/// How closely contour and edges are searched.
struct OutlineCloseness {
  const ContourSearch& contour;
  double edges;
};

/// A snapshot tells nothing: too few of its pixels have a gradient.
bool is_bare(const TextureTerms& snapshot);

/// One Gauss-Newton loop, coarse to fine: linearizes every modality at the pose, adds their normal equations to those
/// of the motion prior, steps, until the step is small.
class Aligner {
 public:
  Aligner(const Device::Impl& device, const Mesh& mesh, const std::vector<Level>& levels, const Extent& extent,
          const Tuning& tuning, ViewTemplate& view, DeviceImage& image);

  void start_frame(const TrackingState& state, const MotionPrior& prior);

  /// Aligns the object from a start. What is known is taken, and nothing of it changed.
  Alignment align(const Pose& T_start, const AlignmentPlan& plan, const TrackingState& state);

  /// One view and one solution: the paper's tracker.
  Alignment align_once(const Pose& T_start, const TrackingState& state);

  /// Draws the view at a pose as `imaging` shows it; false where the object is out of view.
  bool draw(const Pose& T_camera_object, int finest, int count, const TrackingState& state, const ImagingState& imaging,
            bool across = false);

  /// Equations of contour and edges together.
  NormalEquations outline_equations(const Alignment& alignment, const TrackingState& state) const;
  /// The same as they were found, but for turns that no outline shows.
  NormalEquations outline_alone(const Alignment& alignment) const;

  /// How well the view fits where it was drawn, motion left alone.
  ExposureFit fit(const Pose& T_camera_object, const TrackingState& state, ImagingState imaging, bool across = false);

  /// Keeps the frame's pixels of the object at this pose, to be compared with the next frames'. False where it is out
  /// of view.
  bool take_snapshot(const Pose& T_camera_object, const TrackingState& state);

  /// Combined score of an alignment, 1 where everything is as usual.
  double score(const Alignment& alignment, const TrackingState& state, double usual_texture_score) const;

  double corner_motion(const Pose& T_a, const Pose& T_b) const;
  /// Row stride of the pixels to look at on a level.
  int row_stride(int level, const TrackingState& state) const;

  TextureModality& texture() { return texture_; }
  ContourModality& contour() { return contour_; }
  EdgeModality& edges() { return edges_; }
  DepthView& shape() { return shape_; }
  ShiftSearch& shift_search() { return shift_search_; }
  StageTimes& times() { return times_; }
  int& solved_systems() { return solved_systems_; }
  /// Work done for this frame, milliseconds on one core of an ordinary computer: counted, not measured, so that what
  /// hangs on it does not hang on the machine.
  double nominal_ms() const { return nominal_ms_; }

 private:
  ViewRequest view_request(const Pose& T_camera_object, int finest, int count, const TrackingState& state,
                           const ImagingState& imaging, bool across) const;
  void iterate(Alignment& alignment, int level, const AlignmentPlan& plan, const TrackingState& state,
               const Pose& T_start);
  /// Motion and pixels tell where the object is beside the snapshot, whose own pose only the outline knows: what is
  /// left of them once that is eliminated, and by how much the snapshot seems off.
  NormalEquations about_snapshot(const NormalEquations& relative, const TrackingState& state, Twist& shift) const;
  NormalEquations prior_equations(const Pose& T_camera_object, const AlignmentPlan& plan, const Pose& T_start) const;
  void measure(Alignment& alignment, const AlignmentPlan& plan, const TrackingState& state, const Pose& T_start);
  bool spares_contour(const TextureTerms& texture, const NormalEquations& prior, const TrackingState& state) const;
  void shift(Alignment& alignment, int level);
  /// Contour and edges are linearized at the alignment's pose.
  void look_at_outline(Alignment& alignment, int level, const OutlineCloseness& search, const TrackingState& state);
  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  Extent extent_;
  Tuning tuning_;
  ViewTemplate& view_;
  DeviceImage& image_;
  TextureModality texture_;
  std::vector<Twist> round_turns_;
  DepthView shape_;
  ContourModality contour_;
  EdgeModality edges_;
  ShiftSearch shift_search_;
  MotionPrior prior_;
  Matrix6 prior_information_ = Matrix6::Identity();
  double expected_gradient_pixels_ = 0;
  StageTimes times_;
  int solved_systems_ = 0;
  double nominal_ms_ = 0;
};

}  // namespace holdfast
