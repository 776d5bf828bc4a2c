#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "holdfast/error.hpp"
#include "holdfast/holdfast.h"
#include "holdfast/io.hpp"
#include "holdfast/tracker.hpp"

struct holdfast_mesh {
  holdfast::Mesh mesh;
};

struct holdfast_tracker {
  holdfast::Tracker tracker;
};

namespace {

using namespace holdfast;

thread_local std::string last_error;  // of this thread, as C's errno is

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::invalid_argument, what); }

template <class T>
T& required(T* pointer, const char* name) {
  if (pointer == nullptr) refuse(std::string(name) + " is a null pointer");
  return *pointer;
}

holdfast_code code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
      return HOLDFAST_INVALID_ARGUMENT;
    case ErrorCode::model:
      return HOLDFAST_MODEL;
    case ErrorCode::camera:
      return HOLDFAST_CAMERA;
    case ErrorCode::pose:
      return HOLDFAST_POSE;
    case ErrorCode::image:
      return HOLDFAST_IMAGE;
    case ErrorCode::device:
      return HOLDFAST_DEVICE;
    case ErrorCode::renderer:
      return HOLDFAST_RENDERER;
    case ErrorCode::file:
      return HOLDFAST_FILE;
    case ErrorCode::output:
      return HOLDFAST_OUTPUT;
  }
  return HOLDFAST_UNEXPECTED;
}

/// Keeps the message where there is memory for it.
holdfast_code failed(holdfast_code code, const char* message) noexcept {
  try {
    last_error = message;
  } catch (...) {
    last_error.clear();
  }
  return code;
}

/// Runs `work`; turns what it throws into a code.
template <class Work>
holdfast_code guarded(const Work& work) noexcept {
  try {
    work();
    return HOLDFAST_OK;
  } catch (const Error& error) {
    return failed(code_of(error.code()), error.what());
  } catch (const std::exception& error) {
    return failed(HOLDFAST_UNEXPECTED, error.what());
  } catch (...) {
    return failed(HOLDFAST_UNEXPECTED, "unknown");
  }
}

Camera camera_of(const holdfast_camera& given) {
  Camera camera{given.width, given.height, given.fx, given.fy, given.cx, given.cy, {}};
  std::copy(std::begin(given.distortion), std::end(given.distortion), camera.distortion.begin());
  return camera;
}

PixelFormat format_of(holdfast_format format) {
  switch (format) {
    case HOLDFAST_BGR8:
      return PixelFormat::bgr8;
    case HOLDFAST_RGB8:
      return PixelFormat::rgb8;
    case HOLDFAST_RGBA8:
      return PixelFormat::rgba8;
    case HOLDFAST_GREY8:
      return PixelFormat::grey8;
    case HOLDFAST_NV12:
      return PixelFormat::nv12;
    case HOLDFAST_YUYV:
      return PixelFormat::yuyv;
    case HOLDFAST_BGRA8:
      return PixelFormat::bgra8;
  }
  refuse("the frame's format is none of holdfast_format");
}

ImageView view_of(const holdfast_image& image) {
  return {image.data, image.width, image.height, image.stride_bytes, format_of(image.format)};
}

Pose pose_of(const double* values) {
  required(values, "T_camera_object");
  Pose pose = Pose::Identity();
  for (Eigen::Index i = 0; i < 12; ++i) pose.matrix()(i / 4, i % 4) = values[i];
  return pose;
}

template <class Matrix>
void copy_rows(const Matrix& matrix, double* values) {
  for (Eigen::Index i = 0; i < matrix.size(); ++i) values[i] = matrix(i / matrix.cols(), i % matrix.cols());
}

holdfast_reason reason_of(Reason reason) {
  switch (reason) {
    case Reason::none:
      break;
    case Reason::out_of_view:
      return HOLDFAST_REASON_OUT_OF_VIEW;
    case Reason::occluded:
      return HOLDFAST_REASON_OCCLUDED;
    case Reason::too_fast:
      return HOLDFAST_REASON_TOO_FAST;
    case Reason::no_evidence:
      return HOLDFAST_REASON_NO_EVIDENCE;
    case Reason::low_evidence:
      return HOLDFAST_REASON_LOW_EVIDENCE;
    case Reason::ambiguous:
      return HOLDFAST_REASON_AMBIGUOUS;
    case Reason::not_surely_found:
      return HOLDFAST_REASON_NOT_SURELY_FOUND;
    case Reason::light_changed:
      return HOLDFAST_REASON_LIGHT_CHANGED;
  }
  return HOLDFAST_REASON_NONE;
}

/// Nothing for a negative time.
std::optional<double> time_of(double time_s) { return time_s < 0 ? std::nullopt : std::optional(time_s); }

holdfast_result result_of(const FrameResult& found) {
  holdfast_result result{};
  copy_rows(found.T_camera_object.matrix(), result.T_camera_object);
  result.held = found.status == Status::held ? 1 : 0;
  result.visible_pixels = found.visible_pixels();
  const TextureEvidence& texture = found.texture;
  result.texture = {texture.holds ? 1 : 0, texture.gradient_pixels, texture.used_pixels, texture.residual,
                    texture.correlation};
  const ContourEvidence& contour = found.contour;
  result.contour = {contour.holds ? 1 : 0, contour.lines, contour.near_lines, contour.agreement, contour.residual};
  result.edges = {found.edges.lines, found.edges.near_lines, found.edges.score, found.edges.residual};
  const SnapshotEvidence& snapshot = found.snapshot;
  result.snapshot = {snapshot.holds ? 1 : 0, snapshot.gradient_pixels, snapshot.used_pixels, snapshot.correlation};
  copy_rows(found.covariance, result.covariance);
  copy_rows(found.information, result.information);
  result.milliseconds = found.ms.total;
  result.reason = reason_of(found.reason);
  found.message.copy(result.message, sizeof result.message - 1);
  return result;
}

TrackerOptions options_of(const char* mode) {
  const std::string name = mode == nullptr ? "default" : mode;
  if (name == "default") return {};
  if (name == "fast") return TrackerOptions::fast();
  if (name == "paper") return TrackerOptions::paper();
  refuse("mode is '" + name + "': give default, fast or paper");
}

Mesh mesh_of(const holdfast_mesh_arrays& arrays) {
  Mesh mesh;
  const float* p = &required(arrays.positions, "positions");
  for (std::size_t i = 0; i < arrays.vertex_count; ++i) {
    mesh.positions.emplace_back(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
  }
  const std::uint32_t* t = &required(arrays.triangles, "triangles");
  for (std::size_t i = 0; i < arrays.triangle_count; ++i) {
    mesh.triangles.push_back({t[3 * i], t[3 * i + 1], t[3 * i + 2]});
  }
  for (std::size_t i = 0; arrays.texture_coordinates != nullptr && i < arrays.vertex_count; ++i) {
    mesh.texture_coordinates.emplace_back(arrays.texture_coordinates[2 * i], arrays.texture_coordinates[2 * i + 1]);
  }
  if (arrays.texture != nullptr) {
    if (arrays.texture_width <= 0 || arrays.texture_height <= 0) refuse("the texture has no size");
    const std::size_t bytes =
        4 * static_cast<std::size_t>(arrays.texture_width) * static_cast<std::size_t>(arrays.texture_height);
    Texture texture{arrays.texture_width, arrays.texture_height, {arrays.texture, arrays.texture + bytes}};
    mesh.materials.push_back({"texture", std::move(texture)});
  }
  mesh.validate();
  return mesh;
}

}  // namespace

const char* holdfast_version(void) { return HOLDFAST_VERSION; }

const char* holdfast_last_error(void) { return last_error.c_str(); }

holdfast_code holdfast_camera_load(const char* path, int32_t width, int32_t height, holdfast_camera* camera) {
  return guarded([&] {
    holdfast_camera& out = required(camera, "camera");
    Camera loaded = io::load_camera(&required(path, "path"));
    if (width != 0 || height != 0) loaded = io::camera_for_frames(loaded, width, height, false);
    if (loaded.lens != LensModel::polynomial) {
      throw Error(ErrorCode::camera,
                  std::string(path) + ": holdfast_camera has no fisheye lens: undistort the frames first");
    }
    out = {loaded.width, loaded.height, loaded.fx, loaded.fy, loaded.cx, loaded.cy, {}};
    std::copy(loaded.distortion.begin(), loaded.distortion.end(), out.distortion);
  });
}

holdfast_code holdfast_pose_load(const char* path, double T_camera_object[16]) {
  return guarded([&] {
    copy_rows(io::load_pose(&required(path, "path")).matrix(), &required(T_camera_object, "T_camera_object"));
  });
}

holdfast_code holdfast_mesh_load(const char* path, double scale, holdfast_mesh** mesh) {
  return guarded([&] {
    holdfast_mesh*& out = required(mesh, "mesh");
    out = new holdfast_mesh{io::load_model(&required(path, "path"), scale)};
  });
}

holdfast_code holdfast_mesh_create(const holdfast_mesh_arrays* arrays, holdfast_mesh** mesh) {
  return guarded([&] {
    holdfast_mesh*& out = required(mesh, "mesh");
    out = new holdfast_mesh{mesh_of(required(arrays, "arrays"))};
  });
}

void holdfast_mesh_destroy(holdfast_mesh* mesh) { delete mesh; }

holdfast_code holdfast_tracker_create(const holdfast_mesh* mesh, const holdfast_camera* camera, const char* mode,
                                      const char* device, holdfast_tracker** tracker) {
  return guarded([&] {
    holdfast_tracker*& out = required(tracker, "tracker");
    DeviceOptions chosen;
    if (device != nullptr) chosen.device = device;
    out = new holdfast_tracker{
        Tracker(required(mesh, "mesh").mesh, camera_of(required(camera, "camera")), options_of(mode), Device(chosen))};
  });
}

void holdfast_tracker_destroy(holdfast_tracker* tracker) { delete tracker; }

holdfast_code holdfast_tracker_reset(holdfast_tracker* tracker, const double T_camera_object[16],
                                     const holdfast_image* frame, double time_s) {
  return guarded([&] {
    Tracker& used = required(tracker, "tracker").tracker;
    if (frame == nullptr) {
      used.reset(pose_of(T_camera_object));
    } else {
      used.reset(pose_of(T_camera_object), view_of(*frame), time_of(time_s));
    }
  });
}

holdfast_code holdfast_tracker_track(holdfast_tracker* tracker, const holdfast_image* frame, double time_s,
                                     holdfast_result* result) {
  return guarded([&] {
    holdfast_result& out = required(result, "result");
    out = result_of(required(tracker, "tracker").tracker.track(view_of(required(frame, "frame")), time_of(time_s)));
  });
}

holdfast_code holdfast_tracker_refine(holdfast_tracker* tracker, const holdfast_image* frame,
                                      const double T_camera_object[16], holdfast_result* result) {
  return guarded([&] {
    holdfast_result& out = required(result, "result");
    out = result_of(
        required(tracker, "tracker").tracker.refine(view_of(required(frame, "frame")), pose_of(T_camera_object)));
  });
}

holdfast_code holdfast_tracker_mask(const holdfast_tracker* tracker, uint8_t* classes, size_t size) {
  return guarded([&] {
    const PixelMask mask = required(tracker, "tracker").tracker.pixel_mask();
    if (size != mask.classes.size()) {
      refuse("size is " + std::to_string(size) + ": the mask has " + std::to_string(mask.classes.size()) + " bytes");
    }
    std::copy(mask.classes.begin(), mask.classes.end(), &required(classes, "classes"));
  });
}
