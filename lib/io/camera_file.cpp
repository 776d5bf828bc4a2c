#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <string_view>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/calibration_document.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// How much the shapes of one view at two sizes differ by, log of width over height: pixels are whole.
constexpr double kSameShape = 0.02;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw Error(ErrorCode::camera, fmt::format("camera file '{}': {}", path.string(), reason));
}

/// cameraMatrix, camera_matrix, Camera_Matrix: all the same.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name) {
    if (std::isalnum(c)) {
      plain += static_cast<char>(std::tolower(c));
    }
  }
  return plain;
}

const json* find(const json& document, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    for (const auto& [key, value] : document.items()) {
      if (plain_name(key) == name) {
        return &value;
      }
    }
  }
  return nullptr;
}

void flatten(const json& node, std::vector<double>& values, const fs::path& path, const std::string& name) {
  if (node.is_number()) {
    values.push_back(node.get<double>());
  } else if (node.is_array()) {
    for (const json& child : node) {
      flatten(child, values, path, name);
    }
  } else {
    fail(path, fmt::format("'{}' holds something that is not a number", name));
  }
}

/// The numbers of a matrix, row by row: {rows, cols, data: [...]}, nested lists, or one list.
std::vector<double> matrix_values(const json& node, const fs::path& path, const std::string& name) {
  std::vector<double> values;
  const json* data = node.is_object() ? find(node, {"data"}) : &node;
  if (data == nullptr) {
    fail(path, fmt::format("'{}' has no 'data'", name));
  }
  flatten(*data, values, path, name);
  return values;
}

void set_camera_matrix(Camera& camera, const std::vector<double>& k, const fs::path& path) {
  if (k.size() != 9) {
    fail(path, fmt::format("the camera matrix has {} numbers, not 9 (3x3, row by row)", k.size()));
  }
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    fail(path, "the camera matrix is not [fx 0 cx; 0 fy cy; 0 0 1], row by row (is it transposed?)");
  }
  if (std::abs(k[1]) > 1e-6 * std::abs(k[0])) {
    fail(path, fmt::format("the camera matrix has a skew of {}; only cameras without skew are supported", k[1]));
  }
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
}

void set_distortion(Camera& camera, const std::vector<double>& d, const fs::path& path) {
  const bool known = d.empty() || d.size() == 4 || d.size() == 5 || d.size() == 8 || d.size() == 12 || d.size() == 14;
  if (!known) {
    fail(path,
         fmt::format("{} distortion coefficients; supported are 4, 5 or 8: k1 k2 p1 p2 [k3 [k4 k5 k6]]", d.size()));
  }
  if (std::any_of(d.begin() + std::min<std::ptrdiff_t>(8, std::ssize(d)), d.end(), [](double k) { return k != 0; })) {
    fail(path,
         "the thin prism and tilt terms of the distortion are not supported: calibrate with the 4, 5 or 8 "
         "coefficient model");
  }
  std::copy_n(d.begin(), std::min<std::size_t>(8, d.size()), camera.distortion.begin());
}

void require_supported_model(const json& document, const fs::path& path) {
  const json* fisheye = find(document, {"fisheyemodel", "fisheye"});
  const bool is_fisheye = fisheye != nullptr && ((fisheye->is_number() && fisheye->get<double>() != 0) ||
                                                 (fisheye->is_boolean() && fisheye->get<bool>()) ||
                                                 (fisheye->is_string() && plain_name(*fisheye) == "true"));
  std::string model = is_fisheye ? "fisheye" : "";
  if (const json* named = find(document, {"distortionmodel"}); named != nullptr && named->is_string()) {
    model = named->get<std::string>();
  }
  for (const char* supported : {"", "none", "plumbbob", "rationalpolynomial", "radtan", "radialtangential", "opencv"}) {
    if (plain_name(model) == supported) {
      return;
    }
  }
  fail(path, fmt::format("the distortion model '{}' is not supported: calibrate with plumb_bob or rational_polynomial, "
                         "or undistort the frames",
                         model));
}

double number(const json& node, const fs::path& path, const std::string& name) {
  if (!node.is_number()) {
    fail(path, fmt::format("'{}' is not a number", name));
  }
  return node.get<double>();
}

int size_in_pixels(const json& node, const fs::path& path, const std::string& name) {
  const double value = number(node, path, name);
  if (!(value >= 1 && value <= 1e5 && value == std::floor(value))) {
    fail(path, fmt::format("'{}' is {}, not a number of pixels", name, value));
  }
  return static_cast<int>(value);
}

void set_size(Camera& camera, const json& document, const fs::path& path) {
  const json* width = find(document, {"imagewidth", "width"});
  const json* height = find(document, {"imageheight", "height"});
  if (width != nullptr && height != nullptr) {
    camera.width = size_in_pixels(*width, path, "image_width");
    camera.height = size_in_pixels(*height, path, "image_height");
  } else if (const json* size = find(document, {"imagesize", "resolution"}); size != nullptr) {
    if (!size->is_array() || size->size() != 2) {
      fail(path, "'image_size' is not [width, height]");
    }
    camera.width = size_in_pixels((*size)[0], path, "image_size");
    camera.height = size_in_pixels((*size)[1], path, "image_size");
  }
}

Camera camera_from_document(const json& document, const fs::path& path) {
  Camera camera;
  if (!document.is_object()) {
    fail(path, "expected an OpenCV calibration (YAML, JSON, XML), a ROS camera_info YAML, or 'fx fy cx cy' as text");
  }
  if (const json* matrix = find(document, {"cameramatrix", "k", "intrinsicmatrix", "mtx"}); matrix != nullptr) {
    set_camera_matrix(camera, matrix_values(*matrix, path, "camera_matrix"), path);
  } else {
    for (const auto& [name, value] :
         {std::pair{"fx", &camera.fx}, {"fy", &camera.fy}, {"cx", &camera.cx}, {"cy", &camera.cy}}) {
      const json* node = find(document, {name});
      if (node == nullptr) {
        fail(path, "there is neither a camera_matrix nor fx, fy, cx, cy in it");
      }
      *value = number(*node, path, name);
    }
  }
  require_supported_model(document, path);
  if (const json* distortion = find(document, {"distortioncoefficients", "distortioncoeffs", "distcoeffs", "distcoeff",
                                               "distortion", "dist", "d"});
      distortion != nullptr && !distortion->is_null()) {
    set_distortion(camera, matrix_values(*distortion, path, "distortion_coefficients"), path);
  }
  set_size(camera, document, path);
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
    fail(path, fmt::format("{} numbers: expected 'fx fy cx cy' or a 3x3 camera matrix", values.size()));
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
    fail(path, error.what());
  }
}

}  // namespace

Camera load_camera(const fs::path& path) {
  const std::string text = read_text_file(path, "camera file");
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
  cv::Mat distortion(1, static_cast<int>(camera.distortion.size()), CV_64F);
  std::copy(camera.distortion.begin(), camera.distortion.end(), distortion.ptr<double>());
  if (camera.width > 0 && camera.height > 0) {
    storage << "image_width" << camera.width << "image_height" << camera.height;
  }
  storage << "camera_matrix" << cv::Mat(matrix) << "distortion_coefficients" << distortion;
  write_text_file(path, storage.releaseAndGetString());
}

Camera camera_for_frames(const Camera& camera, int width, int height, bool rescale) {
  Camera fitted = camera;
  if (camera.width <= 0 || camera.height <= 0) {
    if (rescale) {
      throw Error(ErrorCode::camera,
                  "the calibration names no size of its own, so it cannot be rescaled: leave --rescale-camera out and "
                  "give fx fy cx cy for frames of this size, or use a calibration file that has a size");
    }
    fitted.width = width;
    fitted.height = height;
  } else if (camera.width != width || camera.height != height) {
    const double shape = static_cast<double>(width) / height, calibrated_shape = 1.0 * camera.width / camera.height;
    if (std::abs(std::log(shape / calibrated_shape)) > kSameShape) {
      throw Error(ErrorCode::camera,
                  fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}, another shape: they are "
                              "cropped, not scaled; give a calibration of frames like these, or one as 'fx fy cx cy'",
                              width, height, camera.width, camera.height));
    }
    if (!rescale) {
      throw Error(ErrorCode::camera,
                  fmt::format("the frames are {}x{} but the camera was calibrated at {}x{}: pass --rescale-camera if "
                              "the frames are the same view scaled",
                              width, height, camera.width, camera.height));
    }
    fitted = camera.rescaled(width, height);
  }
  fitted.validate();
  return fitted;
}

}  // namespace holdfast::io
