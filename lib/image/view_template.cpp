#include "image/view_template.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "image/level_rect.hpp"

namespace holdfast {
namespace {

/// Less motion than this many pixels of the level drawn is left to the Gaussian.
constexpr double kLeastMotionBlur = 1.0;
/// Moments of an exposure: one each two pixels of motion (the blur that follows lets no finer ripple through), up to
/// HF_MOST_TAPS.
constexpr double kPixelsATap = 2.0;

}  // namespace

Renderer view_renderer(const Mesh& mesh, const std::vector<Level>& levels, const RendererOptions& options) {
  const Camera& camera = levels[0].camera;
  return {mesh, std::max(camera.width, levels[0].padded_width), std::max(camera.height, levels[0].padded_height),
          options};
}

ViewTemplate::ViewTemplate(const Device::Impl& device, const Mesh& mesh, Renderer renderer,
                           const std::vector<Level>& levels, ImageFilter& filter)
    : device_(device),
      levels_(levels),
      filter_(filter),
      template_planes_(device, filter, levels[0]),
      renderer_(std::move(renderer)),
      host_rgba_(device.host_memory(levels[0].elements * 4)),
      host_depth_(device.host_memory(levels[0].elements * sizeof(float))) {
  for (const auto& position : mesh.positions) box_.extend(position.cast<double>());
  for (const Level& level : levels) {
    const std::size_t plane = (level.elements + kGuardFloats) * sizeof(float);
    Planes planes;
    planes.value = device.zeroed_buffer(HF_CHANNELS * plane);
    planes.dx = device.zeroed_buffer(HF_CHANNELS * plane);
    planes.dy = device.zeroed_buffer(HF_CHANNELS * plane);
    planes.depth = device.zeroed_buffer(plane);
    planes.usable = device.zeroed_buffer(level.elements + kGuardFloats);
    planes_.push_back(std::move(planes));
    pixels_.push_back(device.zeroed_buffer((level.elements * HF_PIXEL + kGuardFloats) * sizeof(float)));
  }
  const std::size_t largest = levels[0].elements;
  before_motion_ = device.zeroed_buffer((largest * HF_PIXEL + kGuardFloats) * sizeof(float));
  rgba_ = cl::Buffer(device.context, CL_MEM_READ_ONLY, (largest + 2 * HF_RENDER_GUARD) * 4);
  window_depth_ = cl::Buffer(device.context, CL_MEM_READ_ONLY, largest * sizeof(float));
  unpack_ = device.kernel("unpack_view");
  unpack_depth_ = device.kernel("unpack_depth");
  unpack_snapshot_ = device.kernel("unpack_snapshot");
  motion_blur_ = device.kernel("motion_blur");
  halve_depth_ = device.kernel("halve_depth");
}

Rect ViewTemplate::bounds(const Pose& T_camera_object) const {
  const Camera& camera = levels_[0].camera;
  const double least_depth = 1e-3 * box_.diagonal().norm();
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  int in_front = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = T_camera_object * box_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if (corner.z() < least_depth) continue;
    ++in_front;
    const Eigen::Vector2d pixel = camera.project(corner);
    x0 = std::min(x0, pixel.x());
    x1 = std::max(x1, pixel.x());
    y0 = std::min(y0, pixel.y());
    y1 = std::max(y1, pixel.y());
  }
  if (in_front == 0) return {};
  const double width = camera.width, height = camera.height;
  if (in_front < 8) return {0, 0, camera.width, camera.height};
  if (x1 < 0 || y1 < 0 || x0 > width - 1 || y0 > height - 1) return {};
  const int left = static_cast<int>(std::floor(std::max(x0, 0.0)));
  const int top = static_cast<int>(std::floor(std::max(y0, 0.0)));
  const int right = static_cast<int>(std::ceil(std::min(x1, width - 1)));
  const int bottom = static_cast<int>(std::ceil(std::min(y1, height - 1)));
  return {left, top, right - left + 1, bottom - top + 1};
}

bool ViewTemplate::enqueue(const ViewRequest& request, DeviceImage* frame) {
  const int finest = request.finest, count = request.count;
  const Exposure& exposure = request.exposure;
  const Rect object = bounds(request.T_camera_object);
  render_ms_ = 0;
  for (auto& planes : planes_) planes.tiles = {};
  if (object.empty()) return false;
  const auto f = static_cast<std::size_t>(finest);
  const Level& level = levels_[f];
  // What lies around the object within reach of every level's blur and vote must be drawn too, as empty.
  const int around = std::max(HF_BLUR_RADIUS + 2, HF_VOTE_RADIUS + 1) << (count - 1);
  const Rect at_level{object.x >> finest, object.y >> finest, (object.width >> finest) + 2,
                      (object.height >> finest) + 2};
  const Rect rect = aligned(grown(at_level, around), HF_TILE << (count - 1), level.padded_width, level.padded_height);
  if (rect.empty()) return false;

  const auto start = std::chrono::steady_clock::now();
  renderer_.set_shading(request.shading);
  renderer_.set_light_texels(request.light_texels);
  const std::size_t pixel_count = static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height);
  // Drawn into host memory and copied, not into mapped buffers: mapping would wait for the device, which works on the
  // frame meanwhile.
  if (copied_()) copied_.wait();
  const DepthRange range = range_ =
      renderer_.render(request.T_camera_object, level.camera, rect,
                       {frame ? nullptr : host_rgba_.as<std::uint8_t>(), host_depth_.as<float>(), rect.width});
  if (!frame) {
    device_.queue.enqueueWriteBuffer(rgba_, CL_FALSE, HF_RENDER_GUARD * 4, pixel_count * 4, host_rgba_.data());
  }
  device_.queue.enqueueWriteBuffer(window_depth_, CL_FALSE, 0, pixel_count * sizeof(float), host_depth_.data(), nullptr,
                                   &copied_);
  device_.queue.flush();
  T_camera_object_ = request.T_camera_object;
  drawn_ = rect;
  drawn_level_ = f;
  render_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();

  kernel::hf_view view{};
  view.stride = rect.width;
  view.grey = request.grey ? 1 : 0;
  view.near_plane = static_cast<float>(range.near_plane);
  view.far_plane = static_cast<float>(range.far_plane);
  const bool moving = exposure.pixels / (1 << finest) >= kLeastMotionBlur;
  // Strips filter the render as it comes where nothing else is to be made of it.
  const bool as_it_comes = device_.strips && !moving && count == 1 && !frame;
  if (frame) {
    frame->enqueue_pixels(finest);
    set_arguments(unpack_snapshot_, frame->pixels(finest), window_depth_, view, to_kernel(rect),
                  to_kernel(frame->uploaded(finest)), level.layout, pixels_[f], planes_[f].depth);
    device_.enqueue_rows(unpack_snapshot_, rect.width, rect.height);
  } else if (as_it_comes) {
    set_arguments(unpack_depth_, window_depth_, view, to_kernel(rect), level.layout, planes_[f].depth);
    device_.enqueue_rows(unpack_depth_, rect.width, rect.height);
  } else {
    set_arguments(unpack_, rgba_, window_depth_, view, to_kernel(rect), level.layout,
                  moving ? before_motion_ : pixels_[f], planes_[f].depth);
    device_.enqueue_rows(unpack_, rect.width, rect.height);
  }
  if (moving && !frame) enqueue_motion_blur(f, rect, exposure);

  margin_ = request.margin;
  enqueue_levels(rect, finest, count, request.margin, as_it_comes ? view : kernel::hf_view{});
  return true;
}

void ViewTemplate::enqueue_levels(const Rect& rect, int finest, int count, const Margin& margin,
                                  const kernel::hf_view& render) {
  for (int step = 0; step < count; ++step) {
    const auto l = static_cast<std::size_t>(finest + step);
    const Rect level_rect = coarser(rect, step);
    Planes& planes = planes_[l];
    if (step > 0) {
      filter_.enqueue_halve(pixels_[l - 1], levels_[l - 1], level_rect, levels_[l], pixels_[l]);
      set_arguments(halve_depth_, planes_[l - 1].depth, levels_[l - 1].layout, to_kernel(level_rect), levels_[l].layout,
                    planes.depth);
      device_.enqueue_rows(halve_depth_, level_rect.width, level_rect.height);
    }
    // Coarse pixels see more slope each: only what jumps more than a surface of that slope may is an edge.
    kernel::hf_template limits{};
    limits.width = levels_[l].width;
    limits.height = levels_[l].height;
    limits.plane = static_cast<int>(levels_[l].elements);
    limits.least_coverage = static_cast<float>(margin.least_coverage);
    limits.jump = static_cast<float>(margin.depth_jump * (1 << l));
    limits.reach = margin.jump_reach;
    limits.bend = static_cast<float>(margin.bend * (1 << l));
    const TemplatePlanes::Out out{planes.value, planes.dx, planes.dy, planes.usable};
    template_planes_.enqueue(render.stride > 0 ? rgba_ : pixels_[l], render, planes.depth, levels_[l], level_rect,
                             limits, out);
    planes.tiles = {level_rect.x / HF_TILE, level_rect.y / HF_TILE, level_rect.width / HF_TILE,
                    level_rect.height / HF_TILE};
  }
}

Snapshot ViewTemplate::read_snapshot() const {
  Snapshot snapshot{T_camera_object_, static_cast<int>(drawn_level_), drawn_, margin_, false, {}, {}};
  const Level& level = levels_[drawn_level_];
  const auto width = static_cast<std::size_t>(drawn_.width), height = static_cast<std::size_t>(drawn_.height);
  snapshot.pixels.resize(HF_PIXEL * width * height);
  snapshot.depth.resize(width * height);
  read_rect(device_, pixels_[drawn_level_], level, drawn_, HF_PIXEL * sizeof(float), snapshot.pixels.data());
  read_rect(device_, planes_[drawn_level_].depth, level, drawn_, sizeof(float), snapshot.depth.data());
  return snapshot;
}

void ViewTemplate::enqueue_snapshot(const Snapshot& snapshot, int count) {
  for (auto& planes : planes_) planes.tiles = {};
  T_camera_object_ = snapshot.T_camera_object;
  drawn_ = snapshot.rect;
  drawn_level_ = static_cast<std::size_t>(snapshot.finest);
  margin_ = snapshot.margin;
  const Level& level = levels_[drawn_level_];
  write_rect(device_, pixels_[drawn_level_], level, drawn_, HF_PIXEL * sizeof(float), snapshot.pixels.data());
  write_rect(device_, planes_[drawn_level_].depth, level, drawn_, sizeof(float), snapshot.depth.data());
  enqueue_levels(drawn_, snapshot.finest, count, snapshot.margin, {});
}

void ViewTemplate::clear() {
  T_camera_object_ = Pose::Identity();
  for (Planes& planes : planes_) planes.tiles = {};
}

double ViewTemplate::window_depth(int x, int y) const {
  const auto row = static_cast<std::size_t>(y - drawn_.y), column = static_cast<std::size_t>(x - drawn_.x);
  return static_cast<double>(host_depth_.as<float>()[row * static_cast<std::size_t>(drawn_.width) + column]);
}

double ViewTemplate::inverse_depth(double depth) const {
  return (range_.far_plane - depth * (range_.far_plane - range_.near_plane)) / (range_.near_plane * range_.far_plane);
}

std::optional<Eigen::Vector3d> ViewTemplate::normal_at(int x, int y) const {
  constexpr double kJump = 0.02;  // of 1/Z from a pixel to the next: what lies beyond is another surface
  if (x <= drawn_.x || y <= drawn_.y || x + 1 >= drawn_.x + drawn_.width || y + 1 >= drawn_.y + drawn_.height)
    return {};
  bool surface = true;
  const auto inverse = [&](int dx, int dy) {
    const double d = window_depth(x + dx, y + dy);
    surface = surface && d < 1;
    return inverse_depth(d);
  };
  const double here = inverse(0, 0);
  const double slope_x = 0.5 * (inverse(1, 0) - inverse(-1, 0)), slope_y = 0.5 * (inverse(0, 1) - inverse(0, -1));
  if (!surface || std::abs(slope_x) > kJump * here || std::abs(slope_y) > kJump * here) return {};
  // On a plane 1/Z is linear in the image.
  const Camera& camera = levels_[drawn_level_].camera;
  const Eigen::Vector3d normal(camera.fx * slope_x, camera.fy * slope_y,
                               here + slope_x * (camera.cx - x) + slope_y * (camera.cy - y));
  // n . P is the same all over the plane, n . (P / Z) = that / Z: positive as it is written, away from the camera.
  return -normal.normalized();
}

std::optional<Eigen::Vector3d> ViewTemplate::flat_normal(double most_relief) const {
  // On a plane 1/Z = (n . ray) / (n . P), linear in the ray.
  constexpr int kStep = 4, kFewest = 20;
  const Camera& camera = levels_[drawn_level_].camera;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  double squares = 0;
  int count = 0;
  for (int row = 0; row < drawn_.height; row += kStep) {
    for (int column = 0; column < drawn_.width; column += kStep) {
      const double d = window_depth(drawn_.x + column, drawn_.y + row);
      if (d >= 1) continue;
      const double inverse = inverse_depth(d);
      const Eigen::Vector3d ray((drawn_.x + column - camera.cx) / camera.fx, (drawn_.y + row - camera.cy) / camera.fy,
                                1);
      products += ray * ray.transpose();
      sums += inverse * ray;
      squares += inverse * inverse;
      ++count;
    }
  }
  if (count < kFewest) return {};
  const Eigen::Vector3d plane = products.ldlt().solve(sums);
  // dZ = Z^2 d(1/Z).
  const double off = std::sqrt(std::max(0.0, squares - sums.dot(plane)) / count);
  if (off * count > most_relief * squares) return {};
  return -plane.normalized();
}

void ViewTemplate::enqueue_motion_blur(std::size_t level, const Rect& rect, const Exposure& exposure) {
  kernel::hf_exposure e{};
  for (int i = 0; i < 3; ++i) {
    e.v[i] = static_cast<float>(exposure.twist(i));
    e.w[i] = static_cast<float>(exposure.twist(3 + i));
  }
  set_intrinsics(e, levels_[level].camera);
  e.light = exposure.light ? 1 : 0;
  e.across = exposure.across ? 1 : 0;
  e.taps = std::min(HF_MOST_TAPS, 1 + static_cast<int>(std::ceil(exposure.pixels / (kPixelsATap * (1 << level)))));
  set_arguments(motion_blur_, before_motion_, planes_[level].depth, levels_[level].layout, to_kernel(rect), e,
                pixels_[level]);
  device_.enqueue_rows(motion_blur_, rect.width, rect.height);
}

}  // namespace holdfast
