#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "holdfast/pose.hpp"

namespace holdfast {

enum class Status { held, lost };

/// Why an object is lost, or hard to hold.
enum class Reason {
  none,              ///< all is well
  out_of_view,       ///< it is not in the picture, or not found in it
  occluded,          ///< something hides most of it
  too_fast,          ///< it moves faster than can be followed, or is blurred by it
  no_evidence,       ///< nothing to go by: neither texture nor a contour that stands out
  low_evidence,      ///< less agrees than should, and nothing seen in front explains it
  ambiguous,         ///< another pose fits as well, or a turn does not show
  not_surely_found,  ///< lost before, and not surely found again
  light_changed,
};

/// Milliseconds a stage took in one frame (device stages include waiting for the device).
struct StageTimes {
  double upload = 0;
  double render = 0;
  double filter = 0;
  double search = 0;   ///< shift search on the coarsest level
  double solve = 0;    ///< occlusion tests, flow constraints, reduction and solution, all iterations
  double contour = 0;  ///< of these, contour lines and the model's edges, silhouettes included
  double total = 0;
};

/// What the texture said of the pose.
struct TextureEvidence {
  bool asked = false;       ///< it was compared on the finest level
  bool holds = false;       ///< it would be enough alone to hold the object
  int visible_pixels = 0;   ///< pixels of the rendered object inside the frame, estimated from what was looked at
  int usable_pixels = 0;    ///< of those looked at: known texture, off the silhouette's margin
  int gradient_pixels = 0;  ///< of these, with a gradient in the view; with magnitude_test also where (7) fails
  int passed_pixels = 0;    ///< of these, passing the occlusion tests
  int used_pixels = 0;      ///< of these, passing the block vote too: the ones that made rows
  int rows = 0;             ///< flow constraints
  double residual = 0;      ///< root of the weighted mean squared residual, intensity in [0, 1]
  double correlation = 0;   ///< of rendered view and frame over the used pixels, [-1, 1]

  /// Share of the gradient pixels that agree.
  double inlier_ratio() const { return gradient_pixels > 0 ? static_cast<double>(used_pixels) / gradient_pixels : 0; }
};

/// What the contour said of the pose.
struct ContourEvidence {
  bool asked = false;      ///< it was compared on the finest level
  bool holds = false;      ///< it would be enough to hold the object, with the edges and without the texture
  int visible_pixels = 0;  ///< pixels of the frame inside the silhouette
  int lines = 0;           ///< lines across the contour inside the frame
  int telling_lines = 0;   ///< of these, on which the colours of both sides can be told apart
  int near_lines = 0;      ///< of these, with the edge next to the contour
  double agreement = 0;    ///< of colours with the contour over the near lines, [-1, 1]
  double residual = 0;     ///< root of the weighted mean squared distance of the edges, pixels

  /// Agreement times the share of lines whose edge is there.
  double score() const { return lines > 0 ? agreement * near_lines / lines : 0; }
};

/// What the model's edges (creases, borders) said of the pose.
struct EdgeEvidence {
  bool asked = false;   ///< they were compared on the finest level
  int lines = 0;        ///< lines across edges of the model inside the frame
  int near_lines = 0;   ///< of these, with the most telling edge of the frame next to the model's
  double score = 0;     ///< share of near lines beyond what chance makes, at most 1
  double residual = 0;  ///< root of the weighted mean squared distance of the frame's edges, pixels
};

/// Pixels of a model without appearance, compared with how an earlier frame showed them.
struct SnapshotEvidence {
  bool asked = false;       ///< they were compared on the finest level
  bool holds = false;       ///< they would be enough to hold the object
  int gradient_pixels = 0;  ///< of those looked at, with a gradient in the earlier frame
  int used_pixels = 0;      ///< of these, those that agree
  double correlation = 0;   ///< of both frames over these, [-1, 1]
};

struct FrameResult {
  /// Where the object is; when it is lost a guess: where it may have been seen, or would be had it gone on as it moved.
  Pose T_camera_object = Pose::Identity();
  Status status = Status::lost;
  Reason reason = Reason::none;  ///< why the object is lost or hard to hold
  std::string message;           ///< the same in words; empty when all is well
  TextureEvidence texture;
  ContourEvidence contour;
  EdgeEvidence edges;
  SnapshotEvidence snapshot;
  int iterations = 0;  ///< solved systems, all levels and starts
  /// Covariance of the twist xi = (v, w) in T_true = T_camera_object exp(xi): object axes, metres and radians, rotation
  /// about the object's origin (equation 12 in docs/math.md), and its inverse. Zero where nothing tells the pose: the
  /// frame does not, and it is where the object would be had it gone on.
  Matrix6 covariance = Matrix6::Zero();
  Matrix6 information = Matrix6::Zero();
  StageTimes ms;

  /// Pixels of the frame that the object covers, occluded or not.
  int visible_pixels() const { return texture.asked ? texture.visible_pixels : contour.visible_pixels; }
};

/// The fate of a pixel of the frame. Where the texture does not hold the object, the silhouette is unusable and the
/// contour's lines are marked at their feet: used (the edge is next to it), rejected_magnitude (it is elsewhere),
/// no_gradient (nothing tells).
enum class PixelClass : std::uint8_t {
  not_visible = 0,         ///< the object does not cover it
  unusable = 1,            ///< covered, but no known texture, on the silhouette margin, or outside the frame
  no_gradient = 2,         ///< test (5): too little gradient in the rendered view or the frame
  rejected_angle = 3,      ///< test (6): gradients point apart
  rejected_magnitude = 4,  ///< test (7): gradients differ too much
  rejected_vote = 5,       ///< passed, but most of its neighbourhood did not
  used = 6,
};

/// One byte a pixel of the whole frame, rows packed, values of PixelClass.
struct PixelMask {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> classes;
};

/// The rendered view at a frame's pose.
struct RenderedView {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< alpha 0 where nothing or nothing known is drawn
  std::vector<float> depth;        ///< metres, 0 where empty
  Pose T_camera_object = Pose::Identity();
};

}  // namespace holdfast
