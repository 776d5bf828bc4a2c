#include <algorithm>
#include <vector>

#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Pixels that the object moves by for the exposure's kernel to be needed.
constexpr double kMotion = 8;

}  // namespace

void Tracker::Impl::warm_up() {
  // The object facing the camera as it was modelled, its bounding sphere as wide as half the picture.
  const double side = 0.5 * std::min(camera_.width, camera_.height);
  Pose T_camera_object = Pose::Identity();
  T_camera_object.translation() = Eigen::Vector3d(0, 0, 2 * radius_ * camera_.fx / side) - p_object_center_;
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return;
  // It sees its own picture, so that every kernel has something to do and nothing takes long.
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height) *
                                 4);
  const Rect whole{0, 0, camera_.width, camera_.height};
  std::vector<float> depth(rgba.size() / 4);
  view_.renderer().render(T_camera_object, levels_[0].camera, whole, {rgba.data(), depth.data(), 0});
  const auto see = [&](PixelFormat format, const Rect& rect) {
    ImageView frame;
    frame.data = rgba.data();
    frame.width = camera_.width;
    frame.height = camera_.height;
    frame.format = format;
    image_.enqueue_upload(frame, image_.region(rect));
    // The finest is blurred as it comes, the next from what it is converted to.
    for (int level = 0; level < std::min(2, options_.levels); ++level) image_.enqueue_blur(level, coarser(rect, level));
  };
  const Rect corner{0, 0, 1, 1};
  for (const PixelFormat format : {PixelFormat::bgr8, PixelFormat::rgb8, PixelFormat::grey8}) see(format, corner);
  see(PixelFormat::rgba8, whole);
  if (by_outline_) {
    outline_.learn(T_camera_object, finest_);
    outline_.estimate(T_camera_object, finest_);
    outline_.clear();
    outline_.take_effort();
  } else if (options_.mode == Mode::paper) {
    track_once(T_camera_object);
  } else {
    const int coarsest = std::min(finest_ + 1, options_.levels - 1);
    for (int level = finest_; level <= coarsest; ++level) image_.enqueue_blur(level, coarser(whole, level));
    if (options_.correlation_search) search_.enqueue_gradients(image_, coarsest);
    coarse_stage(T_camera_object, options_.correlation_search, coarsest, finest_);
    fine_stage(T_camera_object, coarsest, -1);
    if (options_.outline) {
      outline_.learn(T_camera_object, finest_);
      outline_.estimate_nearby(T_camera_object, finest_);
      outline_.clear();
      outline_.take_effort();
    }
    if (options_.coarse_color) {
      look_.optics.coarse_color.on = true;
      draw(T_camera_object, finest_, 1);
      look_.optics.coarse_color.on = false;
    }
    if (options_.motion_blur) {
      Pose T_before = T_camera_object;
      T_before.translation().x() += kMotion * T_before.translation().z() / camera_.fx;
      motion_.reset(T_before);
      moved_ = true;
      look_.exposure = 1;
      draw(T_camera_object, finest_, 1);
      moved_ = false;
    }
  }
  device_.impl().queue.finish();
  forget_view();
  photometry_.reset();
  motion_ = MotionModel({p_object_center_, radius_}, expects_motion());
  look_ = {};
  looked_at_every_ = 1;
}

}  // namespace holdfast
