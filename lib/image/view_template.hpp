#pragma once

#include <optional>
#include <vector>

#include "base/levels.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer.hpp"
#include "image/device_image.hpp"
#include "image/image_filter.hpp"
#include "image/template_planes.hpp"

namespace holdfast {

/// What the object moved by while the shutter was open: T <- exp(twist) T in all, half of it before the pose drawn.
struct Exposure {
  Twist twist = Twist::Zero();
  double pixels = 0;    ///< longest way of a point in the image, pixels of level 0
  bool light = false;   ///< light adds up, as in a camera; otherwise encoded values do, as in many a simulated frame
  bool across = false;  ///< blurred as much at right angles to the motion: what no motion does
};

/// What is dropped at the silhouette and at depth jumps.
struct Margin {
  double least_coverage = 0.5;  ///< share of the blur's reach that must be known surface for a pixel to be usable
  double depth_jump = 0.02;     ///< relative step in depth
  int jump_reach = 1;           ///< pixels from a jump
  double bend = 0;              ///< relative bend of 1/Z from a pixel to the next at edges between faces; 0: kept
};

/// All that decides how a view looks, but for the mesh and its textures.
struct ViewRequest {
  Pose T_camera_object = Pose::Identity();
  int finest = 0;  ///< level at whose resolution it is drawn
  int count = 1;   ///< levels from there on
  bool grey = false;
  Margin margin;
  Exposure exposure;
  // As the Renderer's functions of these names take them.
  Eigen::Vector3d shading = Eigen::Vector3d::Zero();
  bool light_texels = false;
};

/// The object's pixels as a frame showed them, not filtered.
struct Snapshot {
  Pose T_camera_object = Pose::Identity();
  int finest = 0;  ///< level of the pixels
  Rect rect;       ///< of that level
  Margin margin;
  bool sure = false;          ///< nothing hid the object
  std::vector<float> pixels;  ///< interleaved, four a pixel: three channels, known
  std::vector<float> depth;   ///< metres, 0 where empty
};

/// A renderer of views as large as the levels' become.
Renderer view_renderer(const Mesh& mesh, const std::vector<Level>& levels, const RendererOptions& options);

/// The model as it looks from a pose: rendered, halved and filtered like the frame, ready to be compared with it.
class ViewTemplate {
 public:
  /// Planes of one level; a plane has Level::elements floats.
  struct Planes {
    cl::Buffer value, dx, dy;  ///< three planes each, one a channel
    cl::Buffer depth;          ///< metres, 0 where empty
    cl::Buffer usable;         ///< bytes: HF_NOT_VISIBLE, HF_UNUSABLE or HF_USED
    kernel::hf_rect tiles{};   ///< region that holds the object, in tiles

    /// That region in pixels.
    Rect drawn() const { return {tiles.x * HF_TILE, tiles.y * HF_TILE, tiles.width * HF_TILE, tiles.height * HF_TILE}; }
  };

  /// `renderer`: view_renderer()'s of that mesh.
  ViewTemplate(const Device::Impl& device, const Mesh& mesh, Renderer renderer, const std::vector<Level>& levels,
               ImageFilter& filter);

  /// Pixels of the frame that the object's bounding box covers at this pose, clipped; empty when it is out of view.
  Rect bounds(const Pose& T_camera_object) const;

  /// Draws a view and fills its levels. Returns false when the object is out of view. The call draws at once and
  /// enqueues the rest. Throws as the Renderer does.
  /// `frame`: has its own pixels in place of the model's colours: what the object looks like there. The region that the
  /// view covers must be uploaded; what is not is unknown.
  bool enqueue(const ViewRequest& request, DeviceImage* frame = nullptr);
  /// Reads the snapshot taken last; waits for the device. Shows one again, `count` levels of it.
  Snapshot read_snapshot() const;
  void enqueue_snapshot(const Snapshot& snapshot, int count);

  /// The object was elsewhere when this view was drawn.
  void set_pose(const Pose& T_camera_object) { T_camera_object_ = T_camera_object; }

  /// As if nothing had been drawn yet.
  void clear();

  /// Unit normal, towards the camera (camera axes), of the surface at a pixel of the finest level drawn last; none
  /// beside other surface or none.
  std::optional<Eigen::Vector3d> normal_at(int x, int y) const;

  /// Unit normal, towards the camera (camera axes), of the plane nearest to all the surface drawn last; none where
  /// next to nothing was drawn.
  std::optional<Eigen::Vector3d> flat_normal(double most_relief) const;

  const Planes& planes(int level) const { return planes_[static_cast<std::size_t>(level)]; }
  const Pose& T_camera_object() const { return T_camera_object_; }
  Renderer& renderer() { return renderer_; }
  /// Milliseconds spent drawing in the last enqueue().
  double render_ms() const { return render_ms_; }

 private:
  /// Makes the planes of the levels from the finest level's pixels, or from the render as it comes.
  void enqueue_levels(const Rect& rect, int finest, int count, const Margin& margin, const kernel::hf_view& render);
  /// OpenGL's, 0 to 1, of a pixel of the finest level drawn last, within what was drawn; 1: nothing.
  double window_depth(int x, int y) const;
  /// 1/Z of such a depth, 1 / metres.
  double inverse_depth(double depth) const;

  void enqueue_motion_blur(std::size_t level, const Rect& rect, const Exposure& exposure);

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  ImageFilter& filter_;
  TemplatePlanes template_planes_;
  Renderer renderer_;
  Eigen::AlignedBox3d box_;
  std::vector<Planes> planes_;
  std::vector<cl::Buffer> pixels_;
  cl::Buffer before_motion_;  ///< the finest level's pixels, not yet blurred by motion
  cl::Buffer rgba_, window_depth_;
  HostMemory host_rgba_, host_depth_;
  Rect drawn_;        ///< what the host memory holds, pixels of the level drawn
  DepthRange range_;  ///< of it
  Margin margin_;     ///< of what was drawn last
  std::size_t drawn_level_ = 0;
  cl::Event copied_;  ///< of the host memory
  cl::Kernel unpack_, unpack_depth_, unpack_snapshot_, motion_blur_, halve_depth_;
  Pose T_camera_object_ = Pose::Identity();
  double render_ms_ = 0;
};

}  // namespace holdfast
