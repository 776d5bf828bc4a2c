#include "holdfast/tracker.hpp"

#include <string>

#include "base/tuning.hpp"
#include "holdfast/error.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {
namespace {

const Mesh& validated(const Mesh& mesh, const TrackerOptions& options) {
  mesh.validate();
  if (!mesh.has_appearance() && !options.contour) {
    throw Error(ErrorCode::model,
                "the model has neither texture nor vertex colours, so there is nothing to compare with the frame; give "
                "it a texture first ('holdfast bake' makes one from frames with poses), or follow its contour (option "
                "contour, not of the paper's tracker)");
  }
  return mesh;
}

/// Made first of all, while the device may still be loading its kernels.
Renderer renderer_for(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device) {
  const Tuning tuning = tuning_of(options);
  camera.validate();
  return view_renderer(
      validated(mesh, options), make_levels(camera, tuning.levels),
      {tuning.texture_samples, tuning.mesh_deviation, tuning.shading, tuning.contour, true, device.impl().renderer});
}

}  // namespace

struct Tracker::Impl {
  Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& tracker_options, const Device& on_device)
      : options(tracker_options),
        device(on_device),
        pipeline(mesh, camera, tuning_of(tracker_options), on_device,
                 renderer_for(mesh, camera, tracker_options, on_device)) {}

  /// Calls use(upload) with the frame, which is read only until this returns, however it ends.
  template <typename Frame, typename Use>
  auto with_frame(const Frame& frame, Use&& use) {
    struct FrameInUse {
      DeviceImage& image;
      ~FrameInUse() { image.wait_for_upload(); }
    };
    DeviceImage& image = pipeline.image();
    image.check(frame);
    const FrameInUse in_use{image};
    const UploadFrame upload = [&](const Rect& region) { image.enqueue_upload(frame, region); };
    return use(upload);
  }

  template <typename Frame>
  FrameResult track(const Frame& frame, std::optional<double> time_s) {
    if (!pipeline.started()) {
      throw Error(ErrorCode::invalid_argument, "track() before reset(): the tracker has no first pose");
    }
    return with_frame(frame, [&](const UploadFrame& upload) { return pipeline.track(upload, time_s); });
  }

  void check_start(const Pose& T_camera_object) {
    validate_pose(T_camera_object);
    const Eigen::Vector3d p_camera = T_camera_object * pipeline.extent().p_object_center;
    if (p_camera.z() <= 0) {
      throw Error(ErrorCode::pose,
                  "the pose puts the object behind the camera (z = " + std::to_string(p_camera.z()) +
                      " m); a pose maps the object's points to the camera's axes, z forward: is it camera to object "
                      "(invert it), or in OpenGL's axes (negate its second and third row)?");
    }
    if (pipeline.view().bounds(T_camera_object).empty()) {
      const Camera& camera = pipeline.image().camera();
      throw Error(ErrorCode::pose,
                  "the pose puts the object out of the picture of " + std::to_string(camera.width) + "x" +
                      std::to_string(camera.height) +
                      " pixels; check the camera's focal length and centre, and the pose's unit (metres) and axes (x "
                      "right, y down, z forward)");
    }
  }

  TrackerOptions options;
  Device device;
  Pipeline pipeline;
};

Tracker::Tracker(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device)
    : impl_(with_device_errors("preparing the tracker",
                               [&] { return std::make_unique<Impl>(mesh, camera, options, device); })) {}

Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

void Tracker::reset(const Pose& T_camera_object) {
  impl_->check_start(T_camera_object);
  with_device_errors("starting at a pose", [&] { impl_->pipeline.reset(T_camera_object); });
}

void Tracker::reset(const Pose& T_camera_object, const ImageView& frame, std::optional<double> time_s) {
  impl_->check_start(T_camera_object);
  with_device_errors("starting at a pose", [&] {
    impl_->with_frame(frame,
                      [&](const UploadFrame& upload) { impl_->pipeline.reset(T_camera_object, upload, time_s); });
  });
}

FrameResult Tracker::track(const ImageView& frame, std::optional<double> time_s) {
  return with_device_errors("tracking a frame", [&] { return impl_->track(frame, time_s); });
}

FrameResult Tracker::track(const DeviceImageView& frame, std::optional<double> time_s) {
  return with_device_errors("tracking a frame", [&] { return impl_->track(frame, time_s); });
}

FrameResult Tracker::refine(const ImageView& frame, const Pose& T_camera_object) {
  validate_pose(T_camera_object);
  return with_device_errors("refining a pose", [&] {
    return impl_->with_frame(
        frame, [&](const UploadFrame& upload) { return impl_->pipeline.refine(upload, T_camera_object); });
  });
}

PixelMask Tracker::pixel_mask() const {
  return with_device_errors("reading the pixel mask", [&] { return impl_->pipeline.pixel_mask(); });
}

RenderedView Tracker::rendered_view() const { return impl_->pipeline.rendered_view(); }

void Tracker::set_texture(std::size_t material, const Texture& texture) {
  impl_->pipeline.set_texture(material, texture);
}

const Camera& Tracker::camera() const { return impl_->pipeline.image().camera(); }
const TrackerOptions& Tracker::options() const { return impl_->options; }

std::string Tracker::description() const {
  const DeviceInfo& info = impl_->device.info();
  return info.name + " (" + info.platform + ", " + (impl_->device.impl().strips ? "strips" : "groups") + "), " +
         impl_->pipeline.view().renderer().description();
}

}  // namespace holdfast
