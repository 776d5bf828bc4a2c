#include <nanobind/nanobind.h>

#include "bindings.hpp"

NB_MODULE(_core, module) {
  using namespace holdfast::python;
  module.doc() = "Holdfast's C++ library; import holdfast instead of this module.";
  module.attr("version") = HOLDFAST_VERSION;
  bind_error(module);
  bind_camera(module);
  bind_mesh(module);
  bind_device(module);
  bind_frame_result(module);
  bind_tracker(module);
  bind_renderer(module);
  bind_files(module);
  bind_video(module);
  bind_simulation(module);
  bind_baking(module);
  bind_evaluation(module);
}
