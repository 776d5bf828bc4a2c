#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <string_view>
#include <tuple>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/calibration_document.hpp"
#include "io/calibration_fields.hpp"
#include "io/distortion_fields.hpp"
#include "io/focal_check.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Share of a frame's side that a lens's axis is off its middle in no camera that shows all of its sensor.
constexpr double kFarFromMiddle = 0.15;

/// A frame's width in focal lengths, of a lens that shows straight lines as such: 157 degrees.
constexpr double kWidest = 10;

/// A focal length in widths of the frame: a telescope's rather than a camera's, 3 degrees.
constexpr double kLongest = 20;

constexpr std::size_t kMostCameraBytes = 1'000'000;

/// How much the shapes of one view at two sizes differ by, log of width over height: pixels are whole.
constexpr double kSameShape = 0.02;

void set_camera_matrix(Camera& camera, const std::vector<double>& k, const fs::path& path) {
  if (k.size() != 9) {
    fail_camera(path, fmt::format("the camera matrix has {} numbers, not 9 (3x3, row by row)", k.size()));
  }
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    fail_camera(path, "the camera matrix is not [fx 0 cx; 0 fy cy; 0 0 1], row by row (is it transposed?)");
  }
  if (std::abs(k[1]) > 1e-6 * std::abs(k[0])) {
    fail_camera(path, fmt::format("the camera matrix has a skew of {}; only cameras without skew are supported", k[1]));
  }
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
}

bool is_true(const json& node) {
  return (node.is_number() && node.get<double>() != 0) || (node.is_boolean() && node.get<bool>()) ||
         (node.is_string() && plain_key(node) == "true");
}

/// A lens that is not supported, where another name may be a device's.
bool is_other_lens(const std::string& name) {
  const auto holds = [&name](std::string_view part) { return name.find(part) != name.npos; };
  const auto is = [&name](std::string_view whole) { return name == whole; };
  return std::ranges::any_of(
             std::initializer_list<std::string_view>{"inverse", "omnidir", "equirect", "spher", "panoram", "cylindr",
                                                     "stereographic", "orthographic", "equisolid", "ftheta"},
             holds) ||
         std::ranges::any_of(
             std::initializer_list<std::string_view>{"omni", "mei", "ds", "ucm", "eucm", "unified", "fov"}, is);
}

/// The lens by what the file calls it, under any of the names that are about.
LensModel lens_model(const json& document, const fs::path& path) {
  LensModel lens = LensModel::polynomial;
  if (const json* fisheye = find_field(document, {"fisheyemodel", "fisheye"});
      fisheye != nullptr && is_true(*fisheye)) {
    lens = LensModel::fisheye;
  }
  const json* mirror = find_field(document, {"xi"});
  if (mirror != nullptr && mirror->is_number() && mirror->get<double>() != 0) {
    fail_camera(path, fmt::format("its 'xi' is {}: cameras with a mirror, or of two spheres, are not supported",
                                  mirror->get<double>()));
  }
  for (const std::string_view key :
       {"distortionmodel", "distortiontype", "cameramodel", "modeltype", "lensmodel", "projectionmodel",
        "projectiontype", "projection", "cameratype", "model", "type", "lenstype", "lens"}) {
    const json* named = find_field(document, {key});
    if (named == nullptr || !named->is_string()) continue;
    std::string name = plain_key(*named);
    if (name.starts_with("distortion")) name.erase(0, std::string_view("distortion").size());  // RealSense's
    const bool is_sure = key == "distortionmodel" || key == "cameramodel" || key == "modeltype" || key == "lensmodel" ||
                         key == "projectionmodel" || key == "cameratype";
    const auto is_one_of = [&name](std::initializer_list<std::string_view> names) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    if (is_one_of({"equidistant", "fisheye", "opencvfisheye", "kannalabrandt", "kannalabrandt4", "kannalabrandt8"})) {
      lens = LensModel::fisheye;
    } else if ((is_sure || is_other_lens(name)) &&
               !is_one_of({"", "none", "plumbbob", "rationalpolynomial", "radtan", "radialtangential", "opencv",
                           "pinhole", "perspective", "brown", "brownconrady", "standard", "frame"})) {
      fail_camera(path, fmt::format("the {} '{}' is not supported: calibrate with plumb_bob, rational_polynomial or "
                                    "equidistant, or undistort the frames",
                                    key.starts_with("distortion") ? "distortion model" : "camera model",
                                    named->get<std::string>().substr(0, 40)));
    }
  }
  return lens;
}

int size_in_pixels(const json& node, const fs::path& path, const std::string& name) {
  const double value = number_of(node, path, name);
  if (!(value >= 1 && value <= 1e5 && value == std::floor(value))) {
    fail_camera(path, fmt::format("'{}' is {}, not a number of pixels", name, value));
  }
  return static_cast<int>(value);
}

void set_size(Camera& camera, const json& document, const fs::path& path) {
  const json* width = find_field(document, {"imagewidth", "width", "imagesizewidth", "imgwidth", "w"});
  const json* height = find_field(document, {"imageheight", "height", "imagesizeheight", "imgheight", "h"});
  if (width != nullptr && height != nullptr) {
    camera.width = size_in_pixels(*width, path, "image_width");
    camera.height = size_in_pixels(*height, path, "image_height");
  } else if (const json* size = find_field(document, {"imagesize", "resolution"}); size != nullptr) {
    if (size->is_object()) {
      set_size(camera, *size, path);
      return;
    }
    if (!size->is_array() || size->size() != 2) {
      fail_camera(path, "'image_size' is not [width, height]");
    }
    // Only MATLAB writes both names so; its sizes are rows, columns.
    const std::size_t across = document.contains("ImageSize") && document.contains("RadialDistortion") ? 1 : 0;
    camera.width = size_in_pixels((*size)[across], path, "image_size");
    camera.height = size_in_pixels((*size)[1 - across], path, "image_size");
  }
}

/// The part of the sensor that ROS's frames show (`roi`), and how many of its pixels make one (`binning`).
void apply_region(Camera& camera, const json& document, const fs::path& path) {
  const auto value = [&path](const json& owner, std::string_view name) {
    const json* node = find_field(owner, {name});
    const double read = node == nullptr || node->is_null() ? 0 : number_of(*node, path, std::string(name));
    if (!(read >= 0 && read < 1e5 && read == std::floor(read))) {
      fail_camera(path, fmt::format("'{}' is {}, not a number of pixels", name, read));
    }
    return static_cast<int>(read);
  };
  if (const json* roi = find_field(document, {"roi"}); roi != nullptr && roi->is_object()) {
    const int width = value(*roi, "width"), height = value(*roi, "height");
    camera.cx -= value(*roi, "xoffset");
    camera.cy -= value(*roi, "yoffset");
    if (width > 0 && height > 0) {
      if (camera.width > 0 &&
          (value(*roi, "xoffset") + width > camera.width || value(*roi, "yoffset") + height > camera.height)) {
        fail_camera(path,
                    fmt::format("its 'roi' reaches out of the sensor of {}x{} pixels", camera.width, camera.height));
      }
      camera.width = width;
      camera.height = height;
    }
  }
  const int across = std::max(1, value(document, "binningx")), down = std::max(1, value(document, "binningy"));
  if (across == 1 && down == 1) return;
  if (camera.width < across || camera.height < down) {
    fail_camera(path, "it names a binning, but no size of the frames");
  }
  // Pixels are binned whole: what is left over at the right and the bottom is dropped.
  camera.width -= camera.width % across;
  camera.height -= camera.height % down;
  camera = camera.rescaled(camera.width / across, camera.height / down);
}

void set_intrinsics(Camera& camera, const json& document, const fs::path& path) {
  if (const json* matrix = find_field(document, {"cameramatrix", "k", "intrinsicmatrix", "mtx"}); matrix != nullptr) {
    set_camera_matrix(camera, matrix_values(*matrix, path, "camera_matrix"), path);
    return;
  }
  if (const json* list = find_field(document, {"intrinsics"}); list != nullptr && list->is_array()) {  // Kalibr's
    const std::vector<double> values = matrix_values(*list, path, "intrinsics");
    if (values.size() != 4) {
      fail_camera(path, fmt::format("the intrinsics are {} numbers, not fx fy cx cy", values.size()));
    }
    camera.fx = values[0];
    camera.fy = values[1];
    camera.cx = values[2];
    camera.cy = values[3];
    return;
  }
  // NeRF's and RealSense's names too.
  for (const auto& [name, other, value] : {std::tuple{"fx", "flx", &camera.fx},
                                           {"fy", "fly", &camera.fy},
                                           {"cx", "ppx", &camera.cx},
                                           {"cy", "ppy", &camera.cy}}) {
    const json* node = find_field(document, {name, other});
    if (node == nullptr) {
      fail_camera(path, "there is neither a camera_matrix nor fx, fy, cx, cy in it");
    }
    *value = number_of(*node, path, name);
  }
}

/// The one camera of Kalibr's chain; the document itself where it is no chain.
const json& camera_of_chain(const json& document, const fs::path& path) {
  const json* only = nullptr;
  for (const auto& [name, value] : document.items()) {
    const bool is_camera = value.is_object() && name.starts_with("cam") && value.contains("intrinsics");
    if (!is_camera) continue;
    if (only != nullptr) {
      fail_camera(path, "it holds several cameras: leave only the one whose frames these are");
    }
    only = &value;
  }
  return only != nullptr ? *only : document;
}

Camera camera_from_document(const json& whole, const fs::path& path) {
  Camera camera;
  if (!whole.is_object()) {
    fail_camera(path,
                "expected an OpenCV calibration (YAML, JSON, XML), a ROS camera_info YAML, or 'fx fy cx cy' as text");
  }
  const json& document = camera_of_chain(whole, path);
  camera.lens = lens_model(document, path);
  set_intrinsics(camera, document, path);
  read_distortion(camera, document, path);
  set_size(camera, document, path);
  apply_region(camera, document, path);
  return camera;
}

Camera camera_from_numbers(const std::vector<NumberLine>& lines, const fs::path& path) {
  std::vector<double> values;
  for (const NumberLine& line : lines) {
    values.insert(values.end(), line.values.begin(), line.values.end());
  }
  Camera camera;
  if (values.size() == 4) {
    camera.fx = values[0];
    camera.fy = values[1];
    camera.cx = values[2];
    camera.cy = values[3];
  } else if (values.size() == 9) {
    set_camera_matrix(camera, values, path);
  } else {
    fail_camera(path, fmt::format("{} numbers: expected 'fx fy cx cy' or a 3x3 camera matrix", values.size()));
  }
  return camera;
}

void require_usable(const Camera& camera, const fs::path& path) {
  Camera sized = camera;  // text has no size, which validate() would not let pass
  sized.width = std::max(1, camera.width);
  sized.height = std::max(1, camera.height);
  try {
    sized.validate();
  } catch (const Error& error) {
    fail_camera(path, error.what());
  }
}

}  // namespace

Camera load_camera(const fs::path& path) {
  const std::string text = read_plain_text_file(path, "camera file", kMostCameraBytes);
  const auto lines = parse_numbers(text);
  const Camera camera =
      lines ? camera_from_numbers(*lines, path) : camera_from_document(parse_calibration(text, path), path);
  require_usable(camera, path);
  return camera;
}

void save_camera(const fs::path& path, const Camera& camera) {
  const std::string extension = path.extension().string();
  if (extension != ".yml" && extension != ".yaml" && extension != ".json" && extension != ".xml") {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("camera file '{}' cannot be written: give a name ending in .yml, .json or "
                            ".xml",
                            path.string()));
  }
  require_usable(camera, path);
  cv::FileStorage storage(extension, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const bool fisheye = camera.lens == LensModel::fisheye;
  cv::Mat distortion(1, fisheye ? 4 : static_cast<int>(camera.distortion.size()), CV_64F);
  std::copy_n(camera.distortion.begin(), distortion.cols, distortion.ptr<double>());
  if (camera.width > 0 && camera.height > 0) {
    storage << "image_width" << camera.width << "image_height" << camera.height;
  }
  if (fisheye) {
    storage << "distortion_model"
            << "equidistant";
  }
  storage << "camera_matrix" << cv::Mat(matrix) << "distortion_coefficients" << distortion;
  write_text_file(path, storage.releaseAndGetString());
}

std::optional<std::string> focal_warning(const Camera& camera) {
  if (camera.width <= 0 || camera.height <= 0) return std::nullopt;
  const bool is_short = camera.width > kWidest * camera.fx || camera.height > kWidest * camera.fy;
  const double longer_side = std::max(camera.width, camera.height);
  if (!is_short && std::max(camera.fx, camera.fy) <= kLongest * longer_side) return std::nullopt;
  return fmt::format(
      "the focal length is {:.3g} pixels, far too {} for frames of {}x{}: {}",
      is_short ? std::min(camera.fx, camera.fy) : std::max(camera.fx, camera.fy), is_short ? "short" : "long",
      camera.width, camera.height,
      is_short ? "is it in millimetres (divide it by the sensor's width, multiply it by the frame's), or in shares of "
                 "the frame (multiply it by that)?"
               : "was the camera calibrated at another size, or is it in micrometres?");
}

std::optional<std::string> camera_warning(const Camera& camera) {
  if (camera.width <= 0 || camera.height <= 0) {
    return std::nullopt;
  }
  if (std::optional<std::string> focal = focal_warning(camera)) return focal;
  const double across = std::abs(camera.cx + 0.5 - 0.5 * camera.width) / camera.width;
  const double down = std::abs(camera.cy + 0.5 - 0.5 * camera.height) / camera.height;
  if (across < kFarFromMiddle && down < kFarFromMiddle) {
    return std::nullopt;
  }
  return fmt::format(
      "the camera's principal point ({:.6g}, {:.6g}) lies far from the middle of frames of {}x{}: was the camera "
      "calibrated at another size, or are these frames cropped? then the calibration is wrong for them",
      camera.cx, camera.cy, camera.width, camera.height);
}

Camera camera_for_frames(const Camera& camera, int width, int height, bool rescale) {
  if (width <= 0 || height <= 0) {
    throw Error(ErrorCode::camera,
                fmt::format("the frames have no pixels ({}x{}): was the video opened?", width, height));
  }
  Camera fitted = camera;
  if (camera.width <= 0 || camera.height <= 0) {
    if (rescale) {
      throw Error(ErrorCode::camera,
                  "the calibration names no size of its own, so it cannot be rescaled: give fx fy cx cy for frames of "
                  "this size, or use a calibration file that has a size");
    }
    fitted.width = width;
    fitted.height = height;
  } else if (camera.width != width || camera.height != height) {
    const double shape = static_cast<double>(width) / height, calibrated_shape = 1.0 * camera.width / camera.height;
    if (camera.width == height && camera.height == width) {
      throw Error(
          ErrorCode::camera,
          fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}: width and height exchanged. "
                      "Exchange them in the calibration (MATLAB's ImageSize is rows, columns), or, if the frames are "
                      "turned by 90 degrees, turn them (pictures are read as they are stored, whatever they say of "
                      "their orientation)",
                      width, height, camera.width, camera.height));
    }
    if (std::abs(std::log(shape * calibrated_shape)) < kSameShape && std::abs(std::log(shape)) > kSameShape) {
      throw Error(ErrorCode::camera,
                  fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}: turned by 90 degrees; turn "
                              "the frames or calibrate with frames that stand as these do (pictures are read as they "
                              "are stored, whatever they say of their orientation)",
                              width, height, camera.width, camera.height));
    }
    if (std::abs(std::log(shape / calibrated_shape)) > kSameShape) {
      throw Error(ErrorCode::camera,
                  fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}, another shape: they are "
                              "cropped, not scaled; give a calibration of frames like these, or one as 'fx fy cx cy'",
                              width, height, camera.width, camera.height));
    }
    if (!rescale) {
      throw Error(ErrorCode::camera,
                  fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}: rescale it if "
                              "the frames are the same view scaled",
                              width, height, camera.width, camera.height));
    }
    fitted = camera.rescaled(width, height);
  }
  fitted.validate();
  return fitted;
}

}  // namespace holdfast::io
