#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "common_options.hpp"
#include "evaluation/estimated_poses.hpp"
#include "holdfast/io.hpp"
#include "track/pose_writers.hpp"

namespace holdfast::python {
namespace {

/// Frames per second of the times that are written where none are given: those of images without times.
constexpr double kFrameRate = 30;

std::vector<Pose> load_poses(const std::filesystem::path& path) {
  std::vector<Pose> poses;
  for (const evaluation::EstimatedPoses::Entry& entry : evaluation::load_estimated_poses(path, std::nullopt).entries) {
    poses.push_back(entry.result.T_camera_object);
  }
  return poses;
}

/// A frame without a result is lost.
FrameResult result_argument(nb::handle value) {
  FrameResult result;
  if (value.is_none()) return result;
  if (nb::try_cast(value, result)) return result;
  result.T_camera_object = pose_argument(value, "results");
  result.status = Status::held;
  return result;
}

void save_poses(const std::filesystem::path& path, nb::object results,
                const std::optional<std::vector<double>>& times) {
  std::vector<app::TrackedFrame> frames;
  for (nb::handle value : results) {
    app::TrackedFrame& tracked = frames.emplace_back();
    tracked.frame.index = static_cast<std::int64_t>(frames.size()) - 1;
    tracked.frame.time_s = static_cast<double>(tracked.frame.index) / kFrameRate;
    tracked.result = result_argument(value);
  }
  if (times && times->size() != frames.size()) {
    throw nb::value_error(
        fmt::format("times: has {} for {} results; pass one a result", times->size(), frames.size()).c_str());
  }
  for (std::size_t i = 0; times && i < frames.size(); ++i) frames[i].frame.time_s = (*times)[i];
  app::CsvWriter file(path);
  for (const app::TrackedFrame& tracked : frames) file.write(tracked);
}

}  // namespace

void bind_files(nb::module_& module) {
  module.def(
      "load_pose",
      [](const std::filesystem::path& path) {
        const Pose first = io::load_pose(path);
        const std::optional<std::string> doubt = app::surplus_poses(path);
        if (doubt && PyErr_WarnEx(PyExc_UserWarning, doubt->c_str(), kCaller) != 0) throw nb::python_error();
        return pose_array(first);
      },
      nb::arg("path"),
      "The first pose of a file, 4x4: a 3x4 or 4x4 matrix as text, or TUM (t tx ty tz qx qy qz qw). Warns where the "
      "file holds more, which load_poses() reads.");
  module.def(
      "load_poses", [](const std::filesystem::path& path) { return poses_array(load_poses(path)); }, nb::arg("path"),
      "All poses of a file, Nx4x4: one a line (12 or 16 numbers, or TUM), or the table of save_poses() and 'holdfast "
      "track --poses', guesses of lost frames included.");
  module.def("save_poses", &save_poses, nb::arg("path"), nb::arg("results"), nb::arg("times") = nb::none(),
             nb::sig("def save_poses(path: str | os.PathLike, results: "
                     "typing.Iterable[FrameResult | numpy.typing.NDArray[numpy.float64] | None], times: "
                     "typing.Sequence[float] | None = None) -> None"),
             "Writes the table of 'holdfast track --poses' (CSV), a row a frame. results: of track() or find(), None "
             "for a frame without a pose, or poses, 4x4, as held. times: seconds, one a result; None: 30 frames a "
             "second.");
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
