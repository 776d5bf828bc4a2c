#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <filesystem>
#include <optional>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "common_options.hpp"
#include "holdfast/io.hpp"

namespace holdfast::python {

void bind_files(nb::module_& module) {
  module.def(
      "load_pose",
      [](const std::filesystem::path& path) {
        const Pose first = io::load_pose(path);
        const std::optional<std::string> doubt = app::surplus_poses(path);
        if (doubt && PyErr_WarnEx(PyExc_UserWarning, doubt->c_str(), 1) != 0) throw nb::python_error();
        return pose_array(first);
      },
      nb::arg("path"),
      "The first pose of a file, 4x4: a 3x4 or 4x4 matrix as text, or TUM (t tx ty tz qx qy qz qw). Warns where the "
      "file holds more, which load_poses() reads.");
  module.def(
      "load_poses", [](const std::filesystem::path& path) { return poses_array(io::load_poses(path)); },
      nb::arg("path"), "All poses of a file with one a line, Nx4x4.");
  module.def(
      "save_pose",
      [](const std::filesystem::path& path, nb::object pose) {
        io::save_pose(path, pose_argument(pose, "T_camera_object"));
      },
      nb::arg("path"), nb::arg("T_camera_object"),
      nb::sig("def save_pose(path: str | os.PathLike, T_camera_object: numpy.typing.ArrayLike) -> None"),
      "Writes a 4x4 matrix as text.");
  module.def(
      "unit_warning",
      [](const Mesh& mesh, nb::object pose, const std::optional<Camera>& camera) {
        std::optional<Pose> T_camera_object;
        if (!pose.is_none()) T_camera_object = pose_argument(pose, "T_camera_object");
        return io::unit_warning(mesh, T_camera_object, camera);
      },
      nb::arg("mesh"), nb::arg("T_camera_object") = nb::none(), nb::arg("camera") = nb::none(),
      nb::sig("def unit_warning(mesh: Mesh, T_camera_object: numpy.typing.ArrayLike | None = None, camera: Camera | "
              "None = None) -> str | None"),
      "Names the likely unit when the object's size cannot be right in metres; None when it is plausible.");
}

}  // namespace holdfast::python
