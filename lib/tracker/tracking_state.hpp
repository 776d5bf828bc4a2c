#pragma once

#include <optional>

#include "contour/color_histograms.hpp"
#include "edges/edge_memory.hpp"
#include "imaging/imaging_state.hpp"
#include "judge/alignment.hpp"
#include "motion/motion_filter.hpp"

namespace holdfast {

/// What is usual for each modality on this object in this scene, from the frames that it was held in.
struct UsualEvidence {
  double coarse_score = 1;                        ///< of texture on the coarse levels, running mean
  double texture_score = 0;                       ///< of texture on the finest level, likewise; 0: unknown
  double inlier_ratio = 0;                        ///< of texture where nothing is in front; 0: unknown
  double contour_score = 0;                       ///< 0: unknown
  double contour_near = 1;                        ///< share of its lines whose edge is next to it
  double edge_score = 0;                          ///< 0: unknown
  double edge_share = -1;                         ///< of edges in the information of contour and edges; -1: unknown
  double texture_trust = 1;                       ///< share of texture in the information of both, running mean
  Matrix6 contour_information = Matrix6::Zero();  ///< of the contour where it was last seen
  Matrix6 outline_information = Matrix6::Zero();  ///< the same of contour and edges
  double gain = 1;                                ///< of the frame over the texture
  double unobservable = 0;                        ///< share of the frames that leave a motion unobservable
  double frame_ms = 0;                            ///< nominal work of a held frame, running mean (Aligner::nominal_ms)
  double likeness = 0;                            ///< reliability of texture after the first frame, running mean
  int likeness_frames = 0;                        ///< that it is a mean of
  int held_frames = 0;

  /// Of contour and edges before any is known: barely more than chance makes.
  static constexpr double kFirstScore = 0.6;

  double expected_texture_score() const { return texture_score > 0 ? texture_score : 0.6; }
  double expected_contour_score() const { return contour_score > 0 ? contour_score : kFirstScore; }
  UsualOutline outline() const {
    return {expected_contour_score(), edge_score > 0 ? edge_score : kFirstScore, edge_share, contour_near};
  }
  bool unobservable_usually() const { return held_frames == 0 || unobservable > 0.5; }
};

/// Pixels with a gradient, fewer of which are no texture to go by.
inline constexpr double kFewGradients = 100;
/// Share of the usual score that is believed at once.
inline constexpr double kUsualShare = 0.8;

/// All that is known of the object, as of the last frame. A value: alignments read it, the pipeline changes it once a
/// frame.
struct TrackingState {
  explicit TrackingState(const Extent& extent) : motion(extent) {}

  MotionFilter motion;
  ImagingState imaging;
  ColorHistograms colors;
  EdgeMemory edges;
  UsualEvidence usual;
  bool faceted = false;            ///< flat faces, at whose edges light steps
  bool textured = true;            ///< the model has an appearance to compare with
  int finest = 0;                  ///< level that the pose comes from
  double gradient_pixels = 0;      ///< on that level, in the last frame held; 0: none yet
  double visible_pixels = 0;       ///< of the frame, likewise
  double prediction_error = 1e9;   ///< of the last frame held, pixels
  std::optional<Pose> T_snapshot;  ///< of a model without appearance: where it was in the frame whose pixels show it
  bool sure_snapshot = false;      ///< nothing hid it there
  bool bare_snapshot = false;      ///< there is nothing on the object to compare
  int snapshot_misses = 0;         ///< frames in a row that it was not found in
  int without_outline = 0;         ///< frames in a row that a snapshot held it in and the outline did not show it
  bool left_unobservable = false;  ///< the last frame left a motion unobservable
  int frames_since_colors = 0;     ///< were learned
  int contour_misses = 0;          ///< frames in a row that texture held and the contour's colours did not fit
  double tilt_evidence = 1;        ///< of frames, for this pose and against its mirrored tilt, usual scores
  int tilt_pause = 0;              ///< frames in which they are not compared
  bool print_missing = false;      ///< its outline was seen last, and its print was not there
  bool seen = false;               ///< a frame has shown light and colours at a given pose
  std::optional<Pose> suspected;   ///< while it is lost: where it may have been seen in the last frame
  int probable_frames = 0;         ///< in a row in which it was probably seen, going on as objects move

  bool has_snapshot() const { return !textured && T_snapshot.has_value() && !bare_snapshot; }
  /// Whether the frame is compared with pixels of the object, rendered or seen before.
  bool compares() const { return textured || has_snapshot(); }
  bool fresh() const { return gradient_pixels <= 0 && visible_pixels <= 0; }
  /// Whether the last frame's pose is the frame before's, so that motion blurs the view.
  bool followed() const { return motion.started() && !motion.lost(); }
};

}  // namespace holdfast
