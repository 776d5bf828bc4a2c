// How a pipeline is made and started, and what it shows of the last frame.
#include <algorithm>
#include <utility>

#include "base/one_color.hpp"
#include "base/stopwatch.hpp"
#include "recovery/symmetries.hpp"
#include "tracker/pipeline.hpp"

namespace holdfast {

Pipeline::Pipeline(const Mesh& mesh, const Camera& camera, const Tuning& tuning, const Device& device,
                   Renderer renderer)
    : tuning_(tuning),
      device_(device),
      levels_(make_levels(camera, tuning.levels)),
      extent_{mesh.center().cast<double>(), mesh.radius()},
      filter_(device.impl()),
      view_(device.impl(), mesh, std::move(renderer), levels_, filter_),
      image_(device.impl(), camera, levels_, filter_),
      aligner_(device.impl(), mesh, levels_, extent_, tuning, view_, image_),
      relocalizer_(levels_, extent_, aligner_.shift_search(), view_, image_),
      outline_search_(device_.impl(), levels_, extent_, aligner_.edges().samples(), image_, aligner_.shape()),
      symmetries_(possible_symmetries(mesh)),
      lit_patches_(device.impl(), levels_),
      state_(extent_),
      tried_(extent_) {
  // A model of one colour is followed as if it had none, as long as its outline may be asked.
  const bool plain = tuning.contour && !tuning.paper() && is_of_one_color(mesh);
  has_appearance_ = mesh.has_appearance() && !plain && tuning.texture;
  faceted_ = tuning.shading && has_flat_faces(mesh);
  warm_up();
}

void Pipeline::reset(const Pose& T_camera_object) {
  relocalizer_.clear();
  outline_search_.clear();
  album_.clear();
  state_ = TrackingState(extent_);
  state_.textured = has_appearance_;
  state_.faceted = faceted_;
  state_.edges = aligner_.edges().no_memory();
  state_.finest = 0;
  state_.motion.reset(renormalized(T_camera_object));
  tried_ = state_;  // so that frames allocate nothing
  last_time_.reset();
  frames_ = 0;
  aligner_.contour().use_colors(state_.colors);
  started_ = true;
}

void Pipeline::reset(const Pose& T_camera_object, const UploadFrame& upload, std::optional<double> time) {
  reset(T_camera_object);
  const double t = frame_time(time);
  upload_ = &upload;
  uploaded_ = {};
  prior_ = state_.motion.predict(t);
  choose_finest_level();
  aligner_.start_frame(state_, prior_);
  see(state_.motion.pose(), Given::exactly, state_);
  state_.motion.begin(t);
}

FrameResult Pipeline::refine(const UploadFrame& upload, const Pose& T_start) {
  double total = 0;
  FrameResult result;
  {
    const Stopwatch watch(total);
    // Judged as a pose that was given, not as one to be found again.
    TrackingState asked = state_;
    asked.motion.reset(T_start);
    asked.suspected.reset();
    upload_ = &upload;
    uploaded_ = {};
    prior_ = asked.motion.predict(1);
    aligner_.start_frame(asked, prior_);
    if (!asked.colors.known()) see(T_start, Given::roughly, asked);
    last_ = tuning_.paper() ? follow_once(T_start, asked) : follow_fully({T_start}, false, asked);
    result = report(last_, asked);
    aligner_.contour().use_colors(state_.colors);
  }
  result.ms = aligner_.times();
  result.ms.total = total;
  return result;
}

PixelMask Pipeline::pixel_mask() {
  const Camera& camera = image_.camera();
  PixelMask mask{camera.width, camera.height, {}};
  mask.classes.assign(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height), 0);
  if (last_by_contour_ || !last_.has_texture || !state_.textured) {
    if (last_.has_contour) aligner_.contour().classify(last_.T_camera_object, state_.finest, mask.classes);
    return mask;
  }
  const int finest = state_.finest;
  if (!aligner_.draw(last_.T_camera_object, finest, 1, state_, last_.imaging)) return mask;
  aligner_.texture().photometry().set_object_pair(last_.imaging.texture.light);
  aligner_.texture().start_level(view_, finest);
  TextureState scratch = last_.imaging.texture;
  aligner_.texture().linearize(view_, image_, Pose::Identity(), {finest, finest, 1, false, false}, scratch);
  const Level& level = levels_[static_cast<std::size_t>(finest)];
  const kernel::hf_rect& tiles = view_.planes(finest).tiles;
  std::vector<std::uint8_t> classes(level.elements);
  device_.impl().queue.enqueueReadBuffer(aligner_.texture().constraints().classes(finest), CL_TRUE, 0, classes.size(),
                                         classes.data());
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const int lx = x >> finest, ly = y >> finest;
      if (lx < tiles.x * HF_TILE || ly < tiles.y * HF_TILE || lx >= (tiles.x + tiles.width) * HF_TILE ||
          ly >= (tiles.y + tiles.height) * HF_TILE) {
        continue;
      }
      mask.classes[static_cast<std::size_t>(y * mask.width + x)] =
          classes[static_cast<std::size_t>(level.layout.origin + ly * level.layout.stride + lx)];
    }
  }
  return mask;
}

RenderedView Pipeline::rendered_view() {
  const Camera& camera = levels_[0].camera;
  RenderedView view;
  view.width = camera.width;
  view.height = camera.height;
  view.T_camera_object = last_.T_camera_object;
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  view.rgba.assign(count * 4, 0);
  view.depth.assign(count, 1.0f);
  view_.renderer().set_shading(Eigen::Vector3d::Zero());
  const DepthRange range = view_.renderer().render(view.T_camera_object, camera, {0, 0, view.width, view.height},
                                                   {view.rgba.data(), view.depth.data(), 0});
  for (float& depth : view.depth) {
    depth = depth < 1.0f ? static_cast<float>(range.metric(static_cast<double>(depth))) : 0.0f;
  }
  return view;
}

void Pipeline::set_texture(std::size_t material, const Texture& texture) {
  view_.renderer().set_texture(material, texture);
  if (!state_.textured) state_.usual.likeness_frames = 0;  // the texture that was left is replaced
  has_appearance_ = has_appearance_ || (tuning_.texture && !texture.empty());
  state_.textured = has_appearance_;
}

void Pipeline::warm_up() {
  // The object facing the camera as it was modelled, its bounding sphere as wide as half the picture, sees its own
  // picture, so that every kernel has something to do and nothing takes long.
  const Camera& camera = image_.camera();
  const double side = 0.5 * std::min(camera.width, camera.height);
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(0, 0, 2 * extent_.radius * camera.fx / side) - extent_.p_object_center;
  if (view_.bounds(T).empty()) return;
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 4);
  std::vector<float> depth(rgba.size() / 4);
  view_.renderer().render(T, levels_[0].camera, {0, 0, camera.width, camera.height}, {rgba.data(), depth.data(), 0});
  ImageView frame;
  frame.data = rgba.data();
  frame.width = camera.width;
  frame.height = camera.height;
  for (const PixelFormat format : {PixelFormat::bgr8, PixelFormat::rgb8, PixelFormat::grey8}) {
    frame.format = format;
    image_.enqueue_upload(frame, image_.region({0, 0, 1, 1}));
    image_.enqueue_blur(0, {0, 0, 1, 1});
  }
  frame.format = PixelFormat::rgba8;
  reset(T);
  const UploadFrame upload = [&](const Rect& region) { image_.enqueue_upload(frame, region); };
  reset(T, upload, {});
  Pose T_moved = T;
  T_moved.translation().x() += 8 * T.translation().z() / camera.fx;
  if (tuning_.paper()) {
    track(upload, {});
  } else {
    follow_fully({T}, tuning_.shift_search, state_);
    if (tuning_.motion_blur && state_.textured) {
      state_.motion.reset(T_moved);
      state_.motion.begin(0);
      ImagingState blurred = state_.imaging;
      blurred.exposure.share = 1;
      aligner_.draw(T, state_.finest, 1, state_, blurred);
    }
  }
  device_.impl().queue.finish();
  view_.clear();
  reset(T);  // nothing that was learned counts
  upload_ = nullptr;
  last_ = {};
  started_ = false;
}

}  // namespace holdfast
