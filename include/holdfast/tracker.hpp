#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "holdfast/camera.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"
#include "holdfast/export.hpp"
#include "holdfast/frame_result.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/options.hpp"
#include "holdfast/pose.hpp"

namespace holdfast {

/// Follows one object of known shape through the frames of one camera, by its motion, its texture and its contour
/// together (docs/architecture.md). Not thread-safe; several trackers may run in several threads. One that was moved
/// from may only be assigned to or destroyed.
class HOLDFAST_EXPORT Tracker {
 public:
  /// Builds kernels, renders once and allocates all that frames will need. Where kernels are not in the driver's cache
  /// yet it compiles them, some of them when frames first need them: half a minute, once on a machine.
  /// Throws Error(model, camera, invalid_argument, device, renderer).
  Tracker(const Mesh& mesh, const Camera& camera, const TrackerOptions& options = {}, const Device& device = Device());
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  /// Sets the pose that the next frame starts from, at rest; forgets all else that was learned.
  /// Throws Error(pose) when it is no rigid motion (to 1e-3) or puts the object behind the camera or out of view.
  void reset(const Pose& T_camera_object);
  /// The same, and shows the frame that the pose holds in: colours, light and what is usual are learned from it, so
  /// that the next frame is followed as one in a row. `time_s`: of that frame. Throws as track() too.
  void reset(const Pose& T_camera_object, const ImageView& frame, std::optional<double> time_s = {});

  /// Finds the object in the next frame. Throws Error(image) when the frame is empty, not of the camera's size, has no
  /// data, rows longer than its stride, an odd size (nv12, yuyv) or a buffer that is too small or of another context,
  /// and Error(invalid_argument) before the first reset().
  /// `time_s`: when the frame was taken, seconds, later than the one before (Error(invalid_argument) otherwise);
  /// frames may be missing. Without it frames are one apart; both cannot be mixed between two reset().
  FrameResult track(const ImageView& frame, std::optional<double> time_s = {});
  FrameResult track(const DeviceImageView& frame, std::optional<double> time_s = {});

  /// As track(), without prediction, search or moving on: refines the pose given on this frame. What track() finds
  /// next is what it would have found anyway. Needs no reset() before. Throws Error(image) as track(), and Error(pose)
  /// for a pose that is no rigid motion.
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
