#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"
#include "holdfast/export.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/options.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

enum class Status { held, lost };

/// Milliseconds a stage took in one frame (device stages include waiting for the device).
struct StageTimes {
  double upload = 0;
  double render = 0;
  double filter = 0;
  double search = 0;  ///< coarse correlation search
  double solve = 0;   ///< occlusion tests, flow constraints, reduction and solution, all iterations
  double total = 0;
  double ahead = 0;  ///< that draw_ahead() took for this frame, before it came: part of no other
};

struct FrameResult {
  /// Where the object is; when it is lost a guess: where it may have been seen, or would be had it gone on as it moved.
  Pose T_camera_object = Pose::Identity();
  Status status = Status::lost;
  std::string reason;       ///< in words, why the object is lost or hard to hold; empty when all is well
  bool by_outline = false;  ///< looked for by its outline, because the surface shows next to no texture
  int visible_pixels = 0;   ///< pixels of the rendered object inside the frame, estimated from what was looked at
  // If by_outline, usable and gradient count lines across it, passed and rows those that
  // tell something, used those whose edge is next to it; residual is in pixels, correlation the agreement of colours.
  int usable_pixels = 0;    ///< of these, known texture, off the margin, in the search region, in a row looked at
  int gradient_pixels = 0;  ///< of these, with a gradient in the rendered view, or one in the frame that fails (7)
  int passed_pixels = 0;    ///< of these, passing the occlusion tests (5) to (7)
  int used_pixels = 0;      ///< of these, passing the block vote too: the ones that decided the pose
  int rows = 0;             ///< flow constraints after the redundancy test
  double residual = 0;      ///< root of the weighted mean squared residual, intensity in [0, 1]
  double correlation = 0;   ///< normalised correlation of rendered view and frame over the used pixels, [-1, 1]
  int iterations = 0;       ///< solved systems, all levels
  /// Information (inverse covariance) of the twist xi = (v, w) in T_true = exp(xi) T_camera_object: camera axes, metres
  /// and radians, rotation about the camera's origin (equation 12 in docs/math.md). Zero where nothing tells the pose.
  Matrix6 information = Matrix6::Zero();
  StageTimes ms;
};

/// What became of a pixel of the frame.
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

/// The rendered view at the pose it was last compared at.
struct RenderedView {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< alpha 0 where nothing or nothing known is drawn
  std::vector<float> depth;        ///< metres, 0 where empty
  Pose T_camera_object = Pose::Identity();
};

/// Follows one object of known shape, by its texture or, where the first pose shows next to none, by its outline,
/// through the frames of one camera (DESIGN of the loop: docs/architecture.md). Not thread-safe; several trackers may
/// run in several threads. One that was moved from may only be assigned to or destroyed.
class HOLDFAST_EXPORT Tracker {
 public:
  /// Builds kernels, renders once and allocates all that frames will need. Where kernels are not in the driver's cache
  /// yet it compiles them, some of them when frames first need them: half a minute, once on a machine.
  /// Throws Error(model, camera, invalid_argument, device, renderer).
  Tracker(const Mesh& mesh, const Camera& camera, const TrackerOptions& options = {}, const Device& device = Device());
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  /// Sets the pose that the next frame starts from, at rest; forgets velocity and photometric state.
  /// Throws Error(pose) when it is no rigid motion (to 1e-3) or puts the object behind the camera or out of view.
  void reset(const Pose& T_camera_object);

  /// Finds the object in the next frame. Throws Error(image) when the frame is empty, not of the camera's size, has no
  /// data, rows longer than its stride, an odd size (nv12, yuyv) or a buffer that is too small or of another context,
  /// and Error(invalid_argument) before the first reset().
  FrameResult track(const ImageView& frame);
  FrameResult track(const DeviceImageView& frame);

  /// Draws, while the next frame is waited for, the view that it will be compared with first: track() then answers
  /// sooner, and finds the same. Does nothing where more must be known than is, as before the first frame and after a
  /// loss. Called after pixel_mask(), which otherwise draws the last frame's view again in its place.
  void draw_ahead();

  /// As track(), without prediction, search or moving on: refines the pose given on this frame. What track() finds
  /// next is what it would have found anyway. Throws as track() and, for a pose that is no rigid motion, Error(pose).
  FrameResult refine(const ImageView& frame, const Pose& T_camera_object);

  /// The per-pixel decision of the last frame, at its last iteration on the finest level.
  PixelMask pixel_mask() const;
  /// The rendered view of the last frame.
  RenderedView rendered_view() const;

  /// Replaces a material's texture from the next frame on (for a model that is completed while tracking). Throws
  /// Error(invalid_argument) for a material that the model has not, a model without texture coordinates, or a texture
  /// whose bytes are not its size's.
  void set_texture(std::size_t material, const Texture& texture);

  const Camera& camera() const;
  const TrackerOptions& options() const;
  /// The device and the renderer in words, for reports.
  std::string description() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace holdfast
