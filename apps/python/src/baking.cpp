#include <nanobind/stl/string.h>

#include <new>
#include <string>

#include "arrays.hpp"
#include "baking/model_completion.hpp"
#include "baking/texture_baker.hpp"
#include "bindings.hpp"
#include "fields.hpp"
#include "one_process.hpp"
#include "tracker.hpp"
#include "values.hpp"

/// The tables of what can be chosen of baking.
namespace holdfast::baking {

template <class Visit>
void for_each_field(BakeOptions& o, const Visit& visit) {
  visit("margin", o.margin);
  visit("least_cosine", o.least_cosine);
  visit("tolerance", o.tolerance);
  visit("least_agreement", o.least_agreement);
  visit("least_sharpness", o.least_sharpness);
  visit("better_view", o.better_view);
  visit("confirming_motion", o.confirming_motion);
  visit("looks", o.looks);
}

template <class Visit>
void for_each_field(TextureOptions& o, const Visit& visit) {
  visit("texels_per_metre", o.texels_per_metre);
  visit("padding", o.padding);
  visit("largest_size", o.largest_size);
  visit("unwrap", o.unwrap);
  visit("keep", o.keep);
}

template <class Visit>
void for_each_field(CompletionOptions& o, const Visit& visit) {
  visit("bake", o.bake);
  visit("textures", o.textures);
  visit("opening_frames", o.opening_frames);
  visit("every", o.every);
  visit("least_correlation", o.least_correlation);
  visit("least_used_share", o.least_used_share);
  visit("largest_residual", o.largest_residual);
  visit("least_news", o.least_news);
}

}  // namespace holdfast::baking

namespace holdfast::python {
namespace {

using namespace baking;

void construct_completion(ModelCompletion* self, const Mesh& mesh, const Camera& camera, nb::object frame,
                          nb::object pose, const nb::kwargs& given) {
  require_one_process();
  CompletionOptions options;
  set_fields(options, given);
  const FrameArgument first = frame_argument(frame, "first_frame", std::nullopt);
  const cv::Mat picture = bgr_matrix(first, "first_frame");
  const Pose T_camera_object = pose_argument(pose, "T_camera_object");
  const nb::gil_scoped_release released;
  new (self) ModelCompletion(mesh, camera, picture, T_camera_object, options);
}

bool update(ModelCompletion& self, SharedTracker& tracker, nb::object frame, const FrameResult& result) {
  const FrameArgument given = frame_argument(frame, "frame", std::nullopt);
  const cv::Mat picture = bgr_matrix(given, "frame");
  return unlocked(tracker, [&](Tracker& used) { return self.update(used, picture, result); });
}

void construct_baker(TextureBaker* self, const Mesh& mesh, const Camera& camera, nb::object pose,
                     const nb::kwargs& given) {
  require_one_process();
  CompletionOptions options;
  set_fields(options, given);
  const Pose T_camera_object = pose_argument(pose, "T_camera_object");
  const nb::gil_scoped_release released;
  new (self) TextureBaker(make_baker(mesh, camera, T_camera_object, options.textures, options.bake));
}

bool add_frame(TextureBaker& self, nb::object frame, nb::object pose) {
  require_one_process();
  const FrameArgument given = frame_argument(frame, "frame", std::nullopt);
  const cv::Mat picture = bgr_matrix(given, "frame");
  const Pose T_camera_object = pose_argument(pose, "T_camera_object");
  const nb::gil_scoped_release released;
  return self.add_frame(picture, T_camera_object, PoseSource::given).taken;
}

}  // namespace

void bind_baking(nb::module_& module) {
  nb::class_<TextureBaker> baker_class(module, "TextureBaker", nb::type_slots(kCheckedCalls),
                                       "Makes a mesh's texture from frames with known poses.");
  make_unique_here(baker_class);
  baker_class
      .def("__init__", &construct_baker, nb::arg("mesh"), nb::arg("camera"), nb::arg("T_camera_object"),
           nb::arg("options"),
           nb::sig("def __init__(self, mesh: Mesh, camera: Camera, T_camera_object: numpy.typing.ArrayLike, **options: "
                   "typing.Any) -> None"),
           "T_camera_object: the first pose (4x4), from which the resolution follows. The mesh is unwrapped where it "
           "has "
           "no texture coordinates.\n\n"
           "options: dicts: textures (texels_per_metre, padding, largest_size, unwrap, keep), bake (margin in pixels, "
           "least_cosine, tolerance in levels of 255, looks, ...).")
      .def(
          "add", &add_frame, nb::arg("frame"), nb::arg("T_camera_object"),
          nb::sig("def add(self, frame: numpy.typing.NDArray[numpy.uint8], T_camera_object: numpy.typing.ArrayLike) -> "
                  "bool"),
          "Takes from a frame (HxWx3 uint8, BGR, as recorded) at its pose what it shows; whether it was taken.")
      .def_prop_ro("coverage", &TextureBaker::coverage, "Share of the surface's area that is known.")
      .def_prop_ro("mesh", &TextureBaker::model, "The mesh with the texture as it is now.");

  nb::class_<ModelCompletion> completion_class(
      module, "ModelCompletion", nb::type_slots(kCheckedCalls),
      "A model that gains texture while it is tracked. Make a Tracker of its mesh, and call "
      "update() after each frame.");
  make_unique_here(completion_class);
  completion_class
      .def("__init__", &construct_completion, nb::arg("mesh"), nb::arg("camera"), nb::arg("first_frame"),
           nb::arg("T_camera_object"), nb::arg("options"),
           nb::sig("def __init__(self, mesh: Mesh, camera: Camera, first_frame: numpy.typing.NDArray[numpy.uint8], "
                   "T_camera_object: numpy.typing.ArrayLike, **options: typing.Any) -> None"),
           "first_frame: HxWx3 uint8, BGR, with the object at T_camera_object (4x4). options: as TextureBaker's, and "
           "every, opening_frames, least_correlation, least_used_share, largest_residual, least_news.")
      .def("update", &update, nb::arg("tracker"), nb::arg("frame"), nb::arg("result"),
           nb::sig(
               "def update(self, tracker: Tracker, frame: numpy.typing.NDArray[numpy.uint8], result: FrameResult) -> "
               "bool"),
           "Takes what is new from the frame that the tracker was given last, and gives the tracker the new texture "
           "when "
           "that is worth it. True when the frame was taken.")
      .def_prop_ro("coverage", &ModelCompletion::coverage, "Share of the surface's area that is known.")
      .def_prop_ro("frames_taken", &ModelCompletion::frames_taken, "Frames that gave texture.")
      .def_prop_ro("mesh", &ModelCompletion::model, "The model with what is known now.");
}

}  // namespace holdfast::python
