#include "holdfast/camera.hpp"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>

#include <algorithm>
#include <array>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "common_options.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "values.hpp"

namespace holdfast::python {
namespace {

using Distortion = decltype(Camera::distortion);

LensModel lens_argument(const std::string& name) {
  if (name == "polynomial") return LensModel::polynomial;
  if (name == "fisheye") return LensModel::fisheye;
  throw nb::value_error(("lens: expected polynomial or fisheye, got '" + name + "'").c_str());
}

/// OpenCV's coefficients in any shape: 0, 4, 5 or 8 of them, further ones zero; 0 or 4 of a fisheye lens.
Distortion distortion_argument(nb::handle value, LensModel lens) {
  Distortion distortion{};
  if (value.is_none()) return distortion;
  const nb::object flat = nb::module_::import_("numpy").attr("reshape")(value, nb::make_tuple(1, -1));
  const std::vector<double> given = numbers_argument(flat, "distortion", 1, -1);
  if (lens == LensModel::fisheye && !given.empty() && given.size() != 4) {
    throw nb::value_error(
        fmt::format("distortion: {} coefficients; a fisheye lens has 4: k1 k2 k3 k4", given.size()).c_str());
  }
  constexpr std::array<std::size_t, 6> counts{0, 4, 5, 8, 12, 14};
  if (std::ranges::find(counts, given.size()) == counts.end()) {
    throw nb::value_error(("distortion: " + std::to_string(given.size()) +
                           " coefficients; OpenCV's are 4, 5 or 8: k1 k2 p1 p2 [k3 [k4 k5 k6]]")
                              .c_str());
  }
  const bool surplus =
      std::any_of(given.begin() + static_cast<std::ptrdiff_t>(std::min(given.size(), distortion.size())), given.end(),
                  [](double coefficient) { return coefficient != 0; });
  if (surplus) {
    throw nb::value_error("distortion: only OpenCV's k1 k2 p1 p2 k3 k4 k5 k6 are known; further ones must be zero");
  }
  std::copy_n(given.begin(), std::min(given.size(), distortion.size()), distortion.begin());
  return distortion;
}

Camera checked(const Camera& camera) {
  camera.validate();
  return camera;
}

Camera from_matrix(nb::object matrix, int width, int height, nb::object distortion, const std::string& lens_name) {
  const LensModel lens = lens_argument(lens_name);
  const std::vector<double> k = numbers_argument(matrix, "matrix", 3, 3);
  if (k[1] != 0) {
    throw nb::value_error(fmt::format("matrix: has a skew of {}; only cameras without skew are supported{}", k[1],
                                      lens == LensModel::fisheye ? ": calibrate with cv2.fisheye.CALIB_FIX_SKEW" : "")
                              .c_str());
  }
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    throw nb::value_error("matrix: expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] (is it transposed, or scaled?)");
  }
  return checked({width, height, k[0], k[4], k[2], k[5], distortion_argument(distortion, lens), lens});
}

Camera load(const std::filesystem::path& path, std::optional<int> width, std::optional<int> height, bool rescale) {
  const Camera camera = io::load_camera(path);
  if (width && height) {
    try {
      return io::camera_for_frames(camera, *width, *height, rescale);
    } catch (const Error& error) {
      throw Error(error.code(), app::reworded(error.what(), {{"rescale it if", "pass rescale=True if"}}));
    }
  }
  if (camera.width == 0) {
    throw Error(ErrorCode::camera,
                "'" + path.string() + "' names no size of the frames: pass it, Camera.load(path, width, height)");
  }
  return camera;
}

Numpy<double, nb::shape<3, 3>> matrix_of(const Camera& camera) {
  Eigen::Matrix3d matrix;
  matrix << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return matrix_array<Numpy<double, nb::shape<3, 3>>>(matrix);
}

using Pixels = Numpy<double, nb::shape<-1, 2>>;

Pixels project(const Camera& camera, nb::object points, bool distorted) {
  const std::vector<double> p = numbers_argument(points, "points", -1, 3);
  std::vector<double> pixels;
  pixels.reserve(p.size() / 3 * 2);
  for (std::size_t i = 0; i < p.size(); i += 3) {
    Eigen::Vector2d pixel = camera.project({p[i], p[i + 1], p[i + 2]});
    if (distorted) pixel = camera.distort(pixel);
    pixels.insert(pixels.end(), {pixel.x(), pixel.y()});
  }
  const std::size_t count = pixels.size() / 2;
  return owned_array<Pixels>(std::move(pixels), {count, 2});
}

Pixels distort(const Camera& camera, nb::object given) {
  std::vector<double> pixels = numbers_argument(given, "pixels", -1, 2);
  for (std::size_t i = 0; i < pixels.size(); i += 2) {
    const Eigen::Vector2d pixel = camera.distort({pixels[i], pixels[i + 1]});
    pixels[i] = pixel.x();
    pixels[i + 1] = pixel.y();
  }
  const std::size_t count = pixels.size() / 2;
  return owned_array<Pixels>(std::move(pixels), {count, 2});
}

std::string text_of(const Camera& camera) {
  std::ostringstream text;
  text << "Camera(fx=" << camera.fx << ", fy=" << camera.fy << ", cx=" << camera.cx << ", cy=" << camera.cy
       << ", width=" << camera.width << ", height=" << camera.height
       << (camera.has_distortion() ? ", distortion=..." : "")
       << (camera.lens == LensModel::fisheye ? ", lens='fisheye')" : ")");
  return text.str();
}

}  // namespace

void bind_camera(nb::module_& module) {
  nb::class_<Camera> camera_class(
      module, "Camera", nb::type_slots(kCheckedCalls),
      "Pinhole camera with optional lens distortion. Axes as in OpenCV: x right, y down, z forward; pixel "
      "centres are at integers.");
  make_value(camera_class, &Camera::width, &Camera::height, &Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy,
             &Camera::distortion, &Camera::lens);
  camera_class
      .def(
          "__init__",
          [](Camera* self, double fx, double fy, double cx, double cy, int width, int height, nb::object distortion,
             const std::string& lens_name) {
            const LensModel lens = lens_argument(lens_name);
            new (self) Camera(checked({width, height, fx, fy, cx, cy, distortion_argument(distortion, lens), lens}));
          },
          nb::arg("fx"), nb::arg("fy"), nb::arg("cx"), nb::arg("cy"), nb::arg("width"), nb::arg("height"),
          nb::arg("distortion") = nb::none(), nb::arg("lens") = "polynomial",
          nb::sig("def __init__(self, fx: float, fy: float, cx: float, cy: float, width: int, height: int, distortion: "
                  "numpy.typing.ArrayLike | None = None, lens: str = 'polynomial') -> None"),
          "Focal lengths, principal point and size in pixels. `distortion`: OpenCV's k1 k2 p1 p2 k3 k4 k5 k6, or the "
          "first 4 or 5 of them, in any shape. lens: 'fisheye' where they are k1 k2 k3 k4 of cv2.fisheye, which ROS "
          "and Kalibr call equidistant.")
      .def_static("from_matrix", &from_matrix, nb::arg("matrix"), nb::arg("width"), nb::arg("height"),
                  nb::arg("distortion") = nb::none(), nb::arg("lens") = "polynomial",
                  nb::sig("def from_matrix(matrix: numpy.typing.ArrayLike, width: int, height: int, distortion: "
                          "numpy.typing.ArrayLike | None = None, lens: str = 'polynomial') -> Camera"),
                  "A camera of a 3x3 matrix and distortion as cv2.calibrateCamera returns them, or, with "
                  "lens='fisheye', cv2.fisheye.calibrate.")
      .def_static(
          "load", &load, nb::arg("path"), nb::arg("width") = nb::none(), nb::arg("height") = nb::none(),
          nb::arg("rescale") = false,
          "Reads a calibration of OpenCV (YAML, JSON, XML) or ROS, or a text 'fx fy cx cy', which needs width and "
          "height. `rescale`: width and height are the same view at another size.")
      .def(
          "save", [](const Camera& camera, const std::filesystem::path& path) { io::save_camera(path, camera); },
          nb::arg("path"), "Writes an OpenCV calibration (.yml, .yaml, .json or .xml).")
      .def_ro("fx", &Camera::fx, "Focal length, pixels.")
      .def_ro("fy", &Camera::fy, "Focal length, pixels.")
      .def_ro("cx", &Camera::cx, "Principal point, pixels.")
      .def_ro("cy", &Camera::cy, "Principal point, pixels.")
      .def_ro("width", &Camera::width, "Pixels.")
      .def_ro("height", &Camera::height, "Pixels.")
      .def_prop_ro(
          "distortion",
          [](const Camera& camera) {
            const std::size_t count = camera.lens == LensModel::fisheye ? 4 : 8;
            return owned_array<Numpy<double, nb::shape<-1>>>(
                std::vector<double>(camera.distortion.begin(), camera.distortion.begin() + count), {count});
          },
          "OpenCV's k1 k2 p1 p2 k3 k4 k5 k6; k1 k2 k3 k4 of a fisheye lens.", kNewArray)
      .def_prop_ro(
          "lens", [](const Camera& camera) { return camera.lens == LensModel::fisheye ? "fisheye" : "polynomial"; },
          "'polynomial' or 'fisheye': the model of the distortion.")
      .def_prop_ro("matrix", &matrix_of, "The 3x3 camera matrix.", kNewArray)
      .def("rescaled", &Camera::rescaled, nb::arg("width"), nb::arg("height"),
           "The same camera for frames of another size.")
      .def("project", &project, nb::arg("points"), nb::arg("distorted") = true,
           nb::sig("def project(self, points: numpy.typing.ArrayLike, distorted: bool = True) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "Pixels (Nx2) of points in the camera frame (Nx3, metres, z > 0), of the recorded frame or, with "
           "distorted=False, of the ideal pinhole image.")
      .def("distort", &distort, nb::arg("pixels"),
           nb::sig("def distort(self, pixels: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
           "Pixels (Nx2) of the recorded frame where pixels of the ideal pinhole image (Nx2) are seen.")
      .def("__eq__",
           [](const Camera& a, nb::object other) {
             if (!nb::isinstance<Camera>(other)) return false;
             const Camera& b = nb::cast<const Camera&>(other);
             return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
                    a.cy == b.cy && a.distortion == b.distortion && a.lens == b.lens;
           })
      .def("__repr__", &text_of);
}

}  // namespace holdfast::python
