#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "evaluation/pose_error.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/sequence.hpp"
#include "init/pose_from_points.hpp"
#include "tracker.hpp"
#include "values.hpp"

namespace holdfast::evaluation {

inline auto fields_of(const PoseError* /*error*/) { return std::tuple(&PoseError::translation, &PoseError::rotation); }
inline auto fields_of(const OccluderUse* /*use*/) {
  return std::tuple(&OccluderUse::used, &OccluderUse::on_occluder, &OccluderUse::overlaps);
}

}  // namespace holdfast::evaluation

namespace holdfast::python {
namespace {

using namespace evaluation;

std::vector<Pose> poses_argument(nb::handle values, const char* name) {
  std::vector<Pose> poses;
  for (nb::handle value : values) poses.push_back(pose_argument(value, name));
  return poses;
}

std::vector<FrameRecord> evaluate(SharedTracker& tracker, nb::object frames, nb::object truth,
                                  const std::optional<std::vector<double>>& visible, const std::string& protocol,
                                  int step, int offset, double minimum_visible, bool show_start_frame) {
  ProtocolOptions options;
  if (protocol == "rbot") {
    options.protocol = Protocol::rbot;
  } else if (protocol != "never-reset") {
    throw nb::value_error(("protocol: expected never-reset or rbot, got '" + protocol + "'").c_str());
  }
  options.step = step;
  options.offset = offset;
  options.minimum_visible = minimum_visible;
  options.show_start_frame = show_start_frame;
  const std::vector<Pose> poses = poses_argument(truth, "truth");
  if (!nb::hasattr(frames, "__getitem__")) {
    throw nb::type_error(("frames: expected a list of arrays, got " + described(frames) +
                          "; of a video: [frame.image for frame in Video(...)]")
                             .c_str());
  }
  if (nb::hasattr(frames, "__len__") && nb::len(frames) != poses.size()) {
    throw nb::value_error(
        fmt::format("truth: has {} poses for {} frames; pass one a frame", poses.size(), nb::len(frames)).c_str());
  }
  TrackerUnderTest tested;
  tested.reset = [&](const Pose& T_camera_object) {
    unlocked(tracker, [&](Tracker& used) { used.reset(T_camera_object); });
  };
  tested.reset_on = [&](const Pose& T_camera_object, int i) {
    const FrameArgument frame = frame_argument(frames[nb::int_(i)], "frames", std::nullopt);
    unlocked(tracker, [&](Tracker& used) { used.reset(T_camera_object, frame.view); });
  };
  tested.track = [&](int i) {
    const FrameArgument frame = frame_argument(frames[nb::int_(i)], "frames", std::nullopt);
    return unlocked(tracker, [&](Tracker& used) { return used.track(frame.view); });
  };
  return run_protocol(poses, visible.value_or(std::vector<double>()), tested, options);
}

std::string text_of(const FrameRecord& record) {
  return fmt::format("<FrameRecord of frame {}: {}, {:.2f} mm and {:.2f} degrees off{}>", record.frame,
                     record.result.status == Status::held ? "held" : "lost", 1000 * record.error.distance(),
                     record.error.rotation * 180 / std::numbers::pi,
                     record.failed    ? ", failed"
                     : record.counted ? ""
                                      : ", not counted");
}

nb::tuple error_of(nb::object truth, nb::object estimate) {
  const PoseError error = pose_error(pose_argument(truth, "truth"), pose_argument(estimate, "estimate"));
  return nb::make_tuple(error.distance(), error.rotation);
}

struct PoseOfPoints {
  Pose T_camera_object;
  Camera camera;
  double rms = 0;
  std::vector<std::string> warnings;
};

PoseOfPoints pose_from_points(nb::object points, nb::object pixels, const std::optional<Camera>& camera,
                              std::optional<int> width, std::optional<int> height) {
  const std::vector<double> p = numbers_argument(points, "points", -1, 3);
  const std::vector<double> q = numbers_argument(pixels, "pixels", static_cast<int>(p.size() / 3), 2);
  std::vector<app::PointPair> pairs;
  for (std::size_t i = 0; i < p.size() / 3; ++i) {
    pairs.push_back({{p[3 * i], p[3 * i + 1], p[3 * i + 2]}, {q[2 * i], q[2 * i + 1]}, "row " + std::to_string(i)});
  }
  if (!camera && !(width && height)) {
    throw nb::value_error("camera: give a camera, or width and height of the frames to find the focal length too");
  }
  const nb::gil_scoped_release released;
  const app::PoseFromPoints found =
      camera ? app::pose_from_points(pairs, *camera) : app::pose_and_focal_from_points(pairs, *width, *height);
  return {found.T_camera_object, found.camera, found.rms, found.warnings};
}

void bind_first_pose(nb::module_& module) {
  nb::class_<PoseOfPoints> found_class(module, "PoseFromPoints", "A pose that points and their pixels tell.");
  make_value(found_class, &PoseOfPoints::T_camera_object, &PoseOfPoints::camera, &PoseOfPoints::rms,
             &PoseOfPoints::warnings);
  found_class
      .def_prop_ro(
          "T_camera_object", [](const PoseOfPoints& found) { return pose_array(found.T_camera_object); },
          "4x4, object to camera, metres.", kNewArray)
      .def_ro("camera", &PoseOfPoints::camera, "As given, or with the focal length found.")
      .def_ro("rms", &PoseOfPoints::rms, "Root of the mean squared distance of the pixels, pixels.")
      .def_ro("warnings", &PoseOfPoints::warnings, "What to know about this pose.")
      .def("__repr__", [](const PoseOfPoints& found) {
        const auto t = found.T_camera_object.translation();
        return fmt::format("<PoseFromPoints at [{:.4f}, {:.4f}, {:.4f}] m, rms {:.2f} px, {} warnings>", t.x(), t.y(),
                           t.z(), found.rms, found.warnings.size());
      });
  module.def("pose_from_points", &pose_from_points, nb::arg("points"), nb::arg("pixels"),
             nb::arg("camera") = nb::none(), nb::arg("width") = nb::none(), nb::arg("height") = nb::none(),
             nb::sig("def pose_from_points(points: numpy.typing.ArrayLike, pixels: numpy.typing.ArrayLike, camera: "
                     "Camera | None = None, width: int | None = None, height: int | None = None) -> PoseFromPoints"),
             "The pose that sees points of the object (Nx3, metres) at pixels of a recorded frame (Nx2): four or more "
             "of them, not all in one plane if possible. Without a camera, six or more tell the focal length too. "
             "Mistaken pairs are left out, and named in warnings. Raises Error(pose).");
}

}  // namespace

void bind_evaluation(nb::module_& module) {
  bind_first_pose(module);
  nb::class_<FrameRecord> record_class(module, "FrameRecord", "One frame of an evaluation.");
  make_value(record_class, &FrameRecord::frame, &FrameRecord::step, &FrameRecord::offset,
             &FrameRecord::T_camera_object_true, &FrameRecord::result, &FrameRecord::error, &FrameRecord::visible,
             &FrameRecord::counted, &FrameRecord::failed, &FrameRecord::add, &FrameRecord::add_s,
             &FrameRecord::occluder);
  record_class.def_ro("frame", &FrameRecord::frame, "Number of the frame.")
      .def_ro("result", &FrameRecord::result, "What the tracker said.")
      .def_prop_ro(
          "T_camera_object_true", [](const FrameRecord& record) { return pose_array(record.T_camera_object_true); },
          "4x4, object to camera, metres.", kNewArray)
      .def_prop_ro(
          "translation_error", [](const FrameRecord& record) { return record.error.distance(); }, "Metres.")
      .def_prop_ro(
          "rotation_error", [](const FrameRecord& record) { return record.error.rotation; }, "Radians.")
      .def_ro("visible", &FrameRecord::visible, "Visible share of the object's silhouette.")
      .def_ro("counted", &FrameRecord::counted, "Visible enough.")
      .def_ro("failed", &FrameRecord::failed, "Farther off than 50 mm or 5 degrees.")
      .def("__repr__", &text_of);
  module.def(
      "evaluate", &evaluate, nb::arg("tracker"), nb::arg("frames"), nb::arg("truth"), nb::arg("visible") = nb::none(),
      nb::arg("protocol") = "never-reset", nb::arg("step") = 1, nb::arg("offset") = 0, nb::arg("minimum_visible") = 0.0,
      nb::arg("show_start_frame") = true,
      nb::sig("def evaluate(tracker: Tracker, frames: typing.Sequence[numpy.typing.NDArray[numpy.uint8]], truth: "
              "typing.Sequence[numpy.typing.ArrayLike], visible: typing.Sequence[float] | None = None, protocol: "
              "str = 'never-reset', step: int = 1, offset: int = 0, minimum_visible: float = 0, "
              "show_start_frame: bool = True) -> list[FrameRecord]"),
      "Runs a tracker over frames (frames[i] as in Tracker.track) with true poses (Nx4x4). protocol: never-reset "
      "(left alone after the first true pose) or rbot (put back to the truth after 50 mm or 5 degrees; "
      "show_start_frame: "
      "shown the frame that this is the truth of).");
  module.def("pose_error", &error_of, nb::arg("truth"), nb::arg("estimate"),
             nb::sig("def pose_error(truth: numpy.typing.ArrayLike, estimate: numpy.typing.ArrayLike) -> tuple[float, "
                     "float]"),
             "Distance of the origins in metres, and angle between the rotations in radians.");

  using Recorded = evaluation::Sequence;
  nb::class_<Recorded> sequence_class(module, "RecordedSequence",
                                      "A recorded sequence with ground truth: files of a folder.");
  make_value(sequence_class, &Recorded::name, &Recorded::folder, &Recorded::frames, &Recorded::truth,
             &Recorded::occluder_masks, &Recorded::tables, &Recorded::visible, &Recorded::camera, &Recorded::model,
             &Recorded::model_scale);
  sequence_class.def_ro("name", &Recorded::name, "The folder's name.")
      .def_ro("frames", &Recorded::frames, "Image files in order.")
      .def_prop_ro(
          "poses", [](const Recorded& sequence) { return poses_array(sequence.truth); }, "True poses, Nx4x4.",
          kNewArray)
      .def_ro("visible", &Recorded::visible, "Visible share a frame; empty where it is not known.")
      .def_ro("camera", &Recorded::camera, "The camera of the frames.")
      .def_ro("model", &Recorded::model, "File of the model that comes with the sequence; '.' where none does.")
      .def_ro("model_scale", &Recorded::model_scale, "Turns the model's unit into metres.")
      .def("__repr__", [](const Recorded& recorded) {
        return fmt::format("<RecordedSequence {}: {} frames, {} poses>", recorded.name, recorded.frames.size(),
                           recorded.truth.size());
      });
  module.def("load_sequence", &load_sequence, nb::arg("folder"), nb::arg("bop_object") = nb::none(),
             "Reads a folder with frames/, K.txt and poses_gt.txt, as Simulation.save() writes it, or a BOP scene.");
}

}  // namespace holdfast::python
