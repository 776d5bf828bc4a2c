#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "fields.hpp"
#include "one_process.hpp"
#include "simulation/sequence.hpp"
#include "simulation/sequence_files.hpp"
#include "simulation/textured_box.hpp"
#include "values.hpp"

/// The tables of what can be chosen of a simulated sequence.
namespace holdfast::simulation {

template <class Visit>
void for_each_field(MotionOptions& o, const Visit& visit) {
  visit("speed", o.speed);
  visit("nearest", o.nearest);
  visit("farthest", o.farthest);
  visit("rotation_range", o.rotation_range);
  visit("ease", o.ease);
  visit("turns", o.turns);
  visit("margin", o.margin);
}

template <class Visit>
void for_each_field(SensorOptions& o, const Visit& visit) {
  visit("blur_sigma", o.blur_sigma);
  visit("noise", o.noise);
  visit("shot_noise", o.shot_noise);
  visit("exposure_stops", o.exposure_stops);
  visit("white_balance_stops", o.white_balance_stops);
  visit("gamma_stops", o.gamma_stops);
  visit("change_frames", o.change_frames);
  visit("gain", o.gain);
  visit("jpeg_quality", o.jpeg_quality);
}

template <class Visit>
void for_each_field(BackgroundOptions& o, const Visit& visit) {
  visit("file", o.file);
  visit("pan", o.pan);
}

template <class Visit>
void for_each_field(Finish& o, const Visit& visit) {
  visit("specular", o.specular);
  visit("shininess", o.shininess);
}

template <class Visit>
void for_each_field(LightingOptions& o, const Visit& visit) {
  visit("ambient", o.ambient);
  visit("finish", o.finish);
}

template <class Visit>
void for_each_field(SequenceOptions& o, const Visit& visit) {
  visit("frames", o.frames);
  visit("seed", o.seed);
  visit("samples", o.samples);
  visit("motion_blur", o.motion_blur);
  visit("motion", o.motion);
  visit("lighting", o.lighting);
  visit("background", o.background);
  visit("sensor", o.sensor);
}

}  // namespace holdfast::simulation

namespace holdfast::python {
namespace {

using namespace simulation;

MotionStyle style_named(const std::string& name) {
  if (name == "smooth") return MotionStyle::smooth;
  if (name == "sharp") return MotionStyle::sharp;
  if (name == "still") return MotionStyle::still;
  throw nb::value_error(("style: expected smooth, sharp or still, got '" + name + "'").c_str());
}

std::vector<Pose> poses_argument(nb::handle values, const char* name) {
  std::vector<Pose> poses;
  for (nb::handle value : values) poses.push_back(pose_argument(value, name));
  return poses;
}

/// 'bar', 'cube', or a mesh and its poses.
OccluderOptions occluder_argument(nb::handle value) {
  OccluderOptions occluder;
  std::string name;
  if (nb::isinstance<nb::tuple>(value) && nb::len(value) == 2 && nb::isinstance<Mesh>(value[0])) {
    occluder.kind = OccluderKind::mesh;
    occluder.mesh = nb::cast<const Mesh&>(value[0]);
    occluder.T_camera_mesh = poses_argument(value[1], "occluders");
  } else if (nb::try_cast(value, name) && name == "cube") {
    occluder.kind = OccluderKind::cube;
  } else if (name != "bar") {
    throw nb::value_error(
        ("occluders: expected 'bar', 'cube' or (mesh, poses), got " + nb::cast<std::string>(nb::repr(value))).c_str());
  }
  return occluder;
}

void construct(Sequence* self, const Mesh& mesh, const std::optional<Camera>& camera, const std::string& style,
               nb::object poses, nb::object occluders, const nb::kwargs& given) {
  require_one_process();
  SequenceOptions options;
  set_fields(options, given);
  if (camera) options.camera = *camera;
  options.motion.style = style_named(style);
  for (nb::handle occluder : occluders) options.occluders.push_back(occluder_argument(occluder));
  if (!poses.is_none()) {
    options.motion.T_camera_object = poses_argument(poses, "poses");
    if (!given.contains("frames")) options.frames = static_cast<int>(options.motion.T_camera_object.size());
  }
  const nb::gil_scoped_release released;
  new (self) Sequence(mesh, options);
}

SimulatedFrame frame_at(const Sequence& sequence, int index) {
  require_one_process();
  const int i = index < 0 ? index + sequence.size() : index;
  if (i < 0 || i >= sequence.size()) throw nb::index_error("frame index out of range");
  const nb::gil_scoped_release released;
  return sequence.make(i);
}

int save(const Sequence& sequence, const std::filesystem::path& folder, bool masks, bool overwrite, int threads) {
  require_one_process();
  const nb::gil_scoped_release released;
  return write_sequence(sequence, folder, {masks, overwrite, threads, {}});
}

Mesh box(std::uint64_t seed, double contrast, nb::object size) {
  BoxOptions options;
  options.seed = seed;
  options.contrast = contrast;
  if (!size.is_none()) {
    const std::vector<double> edges = numbers_argument(nb::make_tuple(size), "size", 1, 3);
    options.size = {edges[0], edges[1], edges[2]};
  }
  const nb::gil_scoped_release released;
  return textured_box(options);
}

void bind_frame(nb::module_& module) {
  nb::class_<SimulatedFrame> frame_class(module, "SimulatedFrame", "A frame and what is true of it.");
  make_value(frame_class, &SimulatedFrame::image, &SimulatedFrame::jpeg, &SimulatedFrame::T_camera_object,
             &SimulatedFrame::visible_share, &SimulatedFrame::object_mask, &SimulatedFrame::occluder_mask);
  frame_class
      .def_prop_ro(
          "image", [](const SimulatedFrame& frame) { return image_array(frame.image); }, "HxWx3 uint8, BGR.", kNewArray)
      .def_prop_ro(
          "T_camera_object", [](const SimulatedFrame& frame) { return pose_array(frame.T_camera_object); },
          "True pose, 4x4, object to camera, metres.", kNewArray)
      .def_ro("visible_share", &SimulatedFrame::visible_share, "Of the object's silhouette; 0 when it is out of view.")
      .def_prop_ro(
          "object_mask", [](const SimulatedFrame& frame) { return image_array(frame.object_mask); },
          "HxW uint8: share of the pixel that shows the object, times 255.", kNewArray)
      .def_prop_ro(
          "occluder_mask", [](const SimulatedFrame& frame) { return image_array(frame.occluder_mask); },
          "HxW uint8: share of the pixel that shows an occluder, times 255.", kNewArray);
}

}  // namespace

void bind_simulation(nb::module_& module) {
  bind_frame(module);
  module.def(
      "textured_box", &box, nb::arg("seed") = 1, nb::arg("contrast") = 1.0, nb::arg("size") = nb::none(),
      nb::sig("def textured_box(seed: int = 1, contrast: float = 1.0, size: numpy.typing.ArrayLike | None = None) "
              "-> Mesh"),
      "A printed cardboard box, centred, y up, front towards z. contrast: of the print, 0 is plain cardboard. size: "
      "three edges in metres; None: 0.2, 0.15, 0.08.");
  module.def(
      "lettered_cube", [](double edge, std::uint64_t seed) { return lettered_cube(edge, seed); }, nb::arg("edge"),
      nb::arg("seed") = 1, "A toy cube with a letter on each face; edge in metres.");
  nb::class_<Sequence> sequence_class(
      module, "Simulation", nb::type_slots(kCheckedCalls),
      "A sequence with exact ground truth, drawn a frame at a time: simulation[i] is frame i.");
  make_unique_here(sequence_class);
  sequence_class
      .def(
          "__init__", &construct, nb::arg("mesh"), nb::arg("camera") = nb::none(), nb::arg("style") = "smooth",
          nb::arg("poses") = nb::none(), nb::arg("occluders") = nb::list(), nb::arg("options"),
          nb::sig("def __init__(self, mesh: Mesh, camera: Camera | None = None, style: str = 'smooth', poses: "
                  "typing.Sequence[numpy.typing.ArrayLike] | None = None, occluders: typing.Sequence[str | tuple[Mesh, "
                  "typing.Sequence[numpy.typing.ArrayLike]]] = (), **options: typing.Any) -> None"),
          "camera: None: 640x480, 52 degrees wide. style: of the motion: smooth, sharp or still. poses: 4x4, one a "
          "frame, instead of a made motion. occluders: 'bar', 'cube' or (mesh, poses): its poses to the camera, 4x4, "
          "one a "
          "frame.\n\n"
          "options: frames, seed, samples, motion_blur; and dicts: motion (speed in pixels a frame, nearest and "
          "farthest in metres, rotation_range in radians, ease, turns, margin), lighting (ambient, finish), background "
          "(file, pan), sensor (noise, shot_noise in grey levels, blur_sigma in pixels, jpeg_quality, gain, "
          "exposure_stops, white_balance_stops, gamma_stops, change_frames).")
      .def("__len__", &Sequence::size)
      .def("__repr__",
           [](const Sequence& sequence) {
             return fmt::format("<Simulation of {} frames of {}x{} pixels>", sequence.size(), sequence.camera().width,
                                sequence.camera().height);
           })
      .def("__getitem__", &frame_at, nb::arg("index"))
      .def_prop_ro("camera", [](const Sequence& sequence) { return sequence.camera(); })
      .def_prop_ro(
          "poses", [](const Sequence& sequence) { return poses_array(sequence.poses()); },
          "True poses, Nx4x4, object to camera, metres.", kNewArray)
      .def("save", &save, nb::arg("folder"), nb::arg("masks") = false, nb::arg("overwrite") = false,
           nb::arg("threads") = 0,
           "Writes the folder that 'holdfast simulate' writes: frames/, K.txt, poses_gt.txt, visible.txt. Returns how "
           "many frames it has.");
}

}  // namespace holdfast::python
