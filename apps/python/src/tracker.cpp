#include "tracker.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "common_options.hpp"
#include "holdfast/detection.hpp"
#include "holdfast/io.hpp"
#include "texture_argument.hpp"
#include "tracker_options.hpp"
#include "values.hpp"

namespace holdfast::python {

TrackerOptions options_of_mode(const std::string& mode) {
  if (mode == "default") return {};
  if (mode == "fast") return TrackerOptions::fast();
  if (mode == "paper") return TrackerOptions::paper();
  throw nb::value_error(("mode: expected default, fast or paper, got '" + mode + "'").c_str());
}

namespace {

FrameArgument frame_of(const SharedTracker& self, nb::handle value, std::optional<PixelFormat> format) {
  FrameArgument frame = frame_argument(value, "frame", format);
  const Camera& camera = self.tracker.camera();
  if (frame.view.width != camera.width || frame.view.height != camera.height) {
    const bool exchanged = frame.view.width == camera.height && frame.view.height == camera.width;
    throw nb::value_error(("frame: the camera has " + std::to_string(camera.height) + " rows and " +
                           std::to_string(camera.width) + " columns, got " + described(value) +
                           (exchanged ? "; are the camera's width and height exchanged (an array's shape is height, "
                                        "width), or is the frame turned by 90 degrees?"
                                      : ""))
                              .c_str());
  }
  return frame;
}

void warn(const std::string& doubt, int level) {
  if (PyErr_WarnEx(PyExc_UserWarning, doubt.c_str(), level) != 0) throw nb::python_error();
}

/// Warns where the object's size or distance cannot be right; `level`: of the caller's frame.
void warn_about_units(const Mesh& mesh, const std::optional<Pose>& T_camera_object, const Camera& camera, int level) {
  const std::optional<std::string> doubt = io::unit_warning(mesh, T_camera_object, camera);
  if (!doubt) return;
  warn(app::reworded(*doubt,
                     {{"scale it by ", "pass model_scale="}, {"multiply the scale by", "multiply model_scale by"}}),
       level);
}

void construct(SharedTracker* self, const Mesh& mesh, const Camera& camera, const std::string& mode,
               const nb::dict& given, const std::optional<Device>& device) {
  require_one_process();
  TrackerOptions options = options_of_mode(mode);
  set_fields(options, given);
  constexpr int by_the_subclass = kCaller + 1;
  warn_about_units(mesh, {}, camera, by_the_subclass);
  if (const std::optional<std::string> doubt = io::camera_warning(camera)) warn(*doubt, by_the_subclass);
  const nb::gil_scoped_release released;
  new (self) SharedTracker{
      Tracker(mesh, camera, options, device ? *device : Device()), mesh, {}, {}, {}, {{}, {}, {}, true}, {}};
}

void reset(SharedTracker& self, nb::object pose, nb::object frame, std::optional<double> time,
           std::optional<PixelFormat> format) {
  const Pose T_camera_object = pose_argument(pose, "T_camera_object");
  warn_about_units(self.mesh, T_camera_object, self.tracker.camera(), kCaller);
  const auto begin = [&self] {
    if (self.memory) self.memory->begin();
  };
  if (frame.is_none()) {
    unlocked(self, [&](Tracker& tracker) {
      tracker.reset(T_camera_object);
      begin();
    });
    return;
  }
  const FrameArgument given = frame_of(self, frame, format);
  unlocked(self, [&](Tracker& tracker) {
    tracker.reset(T_camera_object, given.view, time);
    begin();
  });
}

/// Keeps what a frame shows of the object as soon as it is known; the next search makes use of it.
void keep_in_mind(SharedTracker& self, const ImageView& frame, const FrameResult& result) {
  if (!self.memory || !self.memory->look(frame, result)) return;
  self.memory->save();
  if (!self.T_guide) self.search.reset();
}

FrameResult track(SharedTracker& self, nb::object frame, std::optional<double> time,
                  std::optional<PixelFormat> format) {
  const FrameArgument given = frame_of(self, frame, format);
  return unlocked(self, [&](Tracker& tracker) {
    FrameResult result = tracker.track(given.view, time);
    keep_in_mind(self, given.view, result);
    return result;
  });
}

/// Looks for the mesh by its texture and what is remembered of it, or near a guide.
app::StartSearch search_for(const SharedTracker& self, const std::optional<Pose>& T_guide) {
  using By = app::StartSearch::By;
  const Camera& camera = self.tracker.camera();
  if (T_guide) {
    const auto near = std::make_shared<const detection::GuideDetector>(self.mesh, camera, *T_guide);
    return {[near](const ImageView& frame) { return near->detect(frame); }, By::guide, *T_guide};
  }
  const auto anywhere = std::make_shared<const detection::Detector>(self.recognition.features(self.mesh), camera);
  return {[anywhere](const ImageView& frame) { return anywhere->detect(frame); },
          self.mesh.has_appearance() ? By::texture : By::sight};
}

void remember(SharedTracker& self, const std::filesystem::path& path) {
  app::Recognition recognition = self.recognition;
  recognition.remembered = path;
  unlocked(self, [&](Tracker& tracker) {
    self.memory.emplace(self.mesh, tracker.camera(), recognition);
    self.recognition = std::move(recognition);
    self.search.reset();
  });
}

std::optional<FrameResult> find(SharedTracker& self, nb::object frame, std::optional<double> time, nb::object guide,
                                std::optional<PixelFormat> format) {
  const FrameArgument given = frame_of(self, frame, format);
  std::optional<Pose> T_guide;
  if (!guide.is_none()) T_guide = pose_argument(guide, "guide");
  return unlocked(self, [&](Tracker& tracker) -> std::optional<FrameResult> {
    const bool same = self.T_guide ? T_guide && self.T_guide->matrix() == T_guide->matrix() : !T_guide;
    if (!self.search || !same) {
      self.search.emplace(search_for(self, T_guide));
      self.T_guide = T_guide;
    }
    if (self.search->found()) self.search->begin();
    const FrameResult result = self.search->look(tracker, given.view, time);
    if (!self.search->found()) return std::nullopt;
    keep_in_mind(self, given.view, result);
    return result;
  });
}

FrameResult refine(SharedTracker& self, nb::object frame, nb::object pose, std::optional<PixelFormat> format) {
  const FrameArgument given = frame_of(self, frame, format);
  const Pose T_camera_object = pose_argument(pose, "T_camera_object");
  return unlocked(self, [&](Tracker& tracker) { return tracker.refine(given.view, T_camera_object); });
}

Numpy<std::uint8_t, nb::shape<-1, -1>> mask(const SharedTracker& self) {
  PixelMask mask = unlocked(self, [](const Tracker& tracker) { return tracker.pixel_mask(); });
  return owned_array<Numpy<std::uint8_t, nb::shape<-1, -1>>>(
      std::move(mask.classes), {static_cast<std::size_t>(mask.height), static_cast<std::size_t>(mask.width)});
}

RenderedView rendered_view(const SharedTracker& self) {
  return unlocked(self, [](const Tracker& tracker) { return tracker.rendered_view(); });
}

void set_texture(SharedTracker& self, std::size_t material, nb::object image) {
  const Texture texture = texture_argument(image, "image");
  unlocked(self, [&](Tracker& tracker) { tracker.set_texture(material, texture); });
}

}  // namespace

void bind_tracker(nb::module_& module) {
  module.def(
      "default_options", [](const std::string& mode) { return fields_dict(options_of_mode(mode)); },
      nb::arg("mode") = "default", nb::sig("def default_options(mode: str = 'default') -> dict[str, typing.Any]"),
      "Names and values of the options that a mode has: default, fast or paper.");

  nb::class_<SharedTracker> tracker_class(module, "Tracker");
  make_unique_here(tracker_class);
  tracker_class
      .def("__init__", &construct, nb::arg("mesh"), nb::arg("camera"), nb::arg("mode"), nb::arg("options"),
           nb::arg("device") = nb::none(), nb::keep_alive<1, 2>())
      .def(
          "reset", &reset, nb::arg("T_camera_object"), nb::arg("frame") = nb::none(), nb::arg("time") = nb::none(),
          nb::arg("format") = nb::none(),
          nb::sig("def reset(self, T_camera_object: numpy.typing.ArrayLike, frame: numpy.typing.NDArray[numpy.uint8] | "
                  "None = None, time: float | None = None, format: PixelFormat | None = None) -> None"),
          "Sets the pose (4x4, object to camera, metres) that the next frame starts from, at rest; forgets velocity "
          "and light. Warns where the object cannot be seen whole at this pose. frame, time, format: of the frame that "
          "this is exactly the pose in, where there is one: colours "
          "and light are learned from it; see track().")
      .def("track", &track, nb::arg("frame").none(), nb::arg("time") = nb::none(), nb::arg("format") = nb::none(),
           nb::sig("def track(self, frame: numpy.typing.NDArray[numpy.uint8], time: float | None = None, format: "
                   "PixelFormat | None = None) -> FrameResult"),
           "Finds the object in the next frame.\n\n"
           "frame: uint8 of the camera's size: HxWx3 (BGR, as OpenCV has it), HxWx4 (RGBA) or HxW (grey). Rows may be "
           "apart (a view of a larger picture); the frame is not copied. format: where it is another one: "
           "PixelFormat.rgb8 "
           "of Pillow and imageio (frame[..., ::-1] is not needed), bgra8 of OpenCV's frames with alpha. A wrong order "
           "is not noticed.\n"
           "time: seconds, of the frame, later than the one before; None: frames come evenly. After a reset all frames "
           "have a time, or none has.\n\n"
           "Raises TypeError or ValueError for an array of another kind or shape, Error(invalid_argument) before the "
           "first reset(). A lost object is no error: see FrameResult.status.")
      .def("find", &find, nb::arg("frame").none(), nb::arg("time") = nb::none(), nb::arg("guide") = nb::none(),
           nb::arg("format") = nb::none(),
           nb::sig("def find(self, frame: numpy.typing.NDArray[numpy.uint8], time: float | None = None, guide: "
                   "numpy.typing.ArrayLike | None = None, format: PixelFormat | None = None) -> FrameResult | None"),
           "Looks for the object without a pose to start from: the frame's result where it is found, and track() goes "
           "on from there; None where it is not, and the tracker is as it was.\n\n"
           "A model with texture or colours is found anywhere in the picture, from any side. What it looks like from "
           "all sides is drawn in the first call, which takes seconds, and kept in the cache folder. One without is "
           "found by what remember() has kept of it.\n"
           "guide: a pose (4x4, object to camera, metres) about as the object is held, to 20 degrees, a fifth of its "
           "distance and a quarter of the picture; needs no texture. It must be seen in three frames in a row, so that "
           "the first two of them are None; the tracker forgets what it has learned when it is seen.\n"
           "frame, time, format: see track().\n\n"
           "Raises Error(model) for a model without look or features where there is no guide and nothing is "
           "remembered, Error(pose) for a guide behind the camera or out of the picture.")
      .def("remember", &remember, nb::arg("path"), nb::sig("def remember(self, path: str | os.PathLike) -> None"),
           "Keeps in this file what frames show of the object from now on, and makes find() look for it: an object "
           "whose model has no texture, or another one than today, is recognized in the next run, or in this one "
           "after a loss. What the file holds already is added to; it is written whenever a held frame has shown a "
           "side that was not known, at most 1.7 MB in all. Such a frame takes a tenth of a second longer. Of a model "
           "without texture nothing is learned between a loss and the next reset().\n\n"
           "Raises Error(file) for a file that is damaged or of another model, Error(output) for one that cannot be "
           "written.")
      .def("refine", &refine, nb::arg("frame").none(), nb::arg("T_camera_object"), nb::arg("format") = nb::none(),
           nb::sig("def refine(self, frame: numpy.typing.NDArray[numpy.uint8], T_camera_object: "
                   "numpy.typing.ArrayLike, format: PixelFormat | None = None) -> FrameResult"),
           "As track(), from the pose given (4x4, metres), without prediction or search. What track() finds next stays "
           "the same.")
      .def("mask", &mask, "HxW uint8, values of PixelClass: what became of each pixel of the last frame.")
      .def("rendered_view", &rendered_view, "The view that the last frame was compared with.")
      .def("set_texture", &set_texture, nb::arg("material"), nb::arg("image"),
           nb::sig("def set_texture(self, material: int, image: numpy.typing.NDArray[numpy.uint8]) -> None"),
           "Replaces a material's texture (as Mesh's image) from the next frame on.")
      .def_prop_ro(
          "camera", [](const SharedTracker& self) { return self.tracker.camera(); }, "The camera of the frames.")
      .def_prop_ro(
          "options", [](const SharedTracker& self) { return fields_dict(self.tracker.options()); },
          nb::sig("def options(self) -> dict[str, typing.Any]"), "The options in use.")
      .def_prop_ro(
          "description", [](const SharedTracker& self) { return self.tracker.description(); },
          "Device and renderer in words.");
}

}  // namespace holdfast::python
