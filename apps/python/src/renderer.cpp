#include "holdfast/renderer.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <mutex>
#include <new>
#include <optional>
#include <tuple>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "holdfast/tracker.hpp"
#include "one_process.hpp"
#include "texture_argument.hpp"
#include "values.hpp"

namespace holdfast::python {
namespace {

struct SharedRenderer {
  Renderer renderer;
  std::mutex mutex;
};

using Region = std::tuple<int, int, int, int>;

RenderedView render(SharedRenderer& self, nb::object pose, const Camera& camera, std::optional<Region> region) {
  require_one_process();
  RenderedView view;
  view.T_camera_object = pose_argument(pose, "T_camera_object");
  const auto [x, y, width, height] = region.value_or(Region(0, 0, camera.width, camera.height));
  if (width <= 0 || height <= 0) throw nb::value_error("region: width and height must be positive");
  view.width = width;
  view.height = height;
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  view.rgba.resize(4 * pixels);
  view.depth.resize(pixels, 1.0F);
  const nb::gil_scoped_release released;
  const std::lock_guard alone(self.mutex);
  const DepthRange range = self.renderer.render(view.T_camera_object, camera, {x, y, width, height},
                                                {view.rgba.data(), view.depth.data(), 0});
  for (float& depth : view.depth) depth = depth < 1.0F ? static_cast<float>(range.metric(depth)) : 0.0F;
  return view;
}

}  // namespace

void bind_renderer(nb::module_& module) {
  nb::class_<SharedRenderer> renderer_class(module, "Renderer", nb::type_slots(kCheckedCalls),
                                            "Draws a mesh on the CPU, without a display and without distortion.");
  make_unique_here(renderer_class);
  renderer_class
      .def(
          "__init__",
          [](SharedRenderer* self, const Mesh& mesh, int width, int height, int texture_samples) {
            require_one_process();
            RendererOptions options;
            options.texture_samples = texture_samples;
            const nb::gil_scoped_release released;
            new (self) SharedRenderer{Renderer(mesh, width, height, options), {}};
          },
          nb::arg("mesh"), nb::arg("width"), nb::arg("height"), nb::arg("texture_samples") = 4,
          "width, height: of the largest region that render() is asked for, pixels. texture_samples: 1, or 4 averaged "
          "as "
          "light.")
      .def("render", &render, nb::arg("T_camera_object"), nb::arg("camera"), nb::arg("region") = nb::none(),
           nb::sig("def render(self, T_camera_object: numpy.typing.ArrayLike, camera: Camera, region: tuple[int, int, "
                   "int, int] | None = None) -> RenderedView"),
           "The view at a pose (4x4, object to camera, metres). region: x, y, width, height in pixels of the frame; "
           "None: "
           "the whole frame.")
      .def(
          "set_texture",
          [](SharedRenderer& self, std::size_t material, nb::object image) {
            const Texture texture = texture_argument(image, "image");
            const nb::gil_scoped_release released;
            const std::lock_guard alone(self.mutex);
            self.renderer.set_texture(material, texture);
          },
          nb::arg("material"), nb::arg("image"),
          nb::sig("def set_texture(self, material: int, image: numpy.typing.NDArray[numpy.uint8]) -> None"),
          "Replaces a material's texture, as Mesh's image.")
      .def_prop_ro("description", [](const SharedRenderer& self) { return self.renderer.description(); });
}

}  // namespace holdfast::python
