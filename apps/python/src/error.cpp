#include "holdfast/error.hpp"

#include <exception>

#include "bindings.hpp"

namespace holdfast::python {

namespace nb = nanobind;

void bind_error(nb::module_& module) {
  nb::enum_<ErrorCode>(module, "ErrorCode", "What kind of thing was wrong.")
      .value("invalid_argument", ErrorCode::invalid_argument, "A value is out of its range.")
      .value("model", ErrorCode::model, "A mesh or its texture cannot be used.")
      .value("camera", ErrorCode::camera, "A camera's parameters cannot be used.")
      .value("pose", ErrorCode::pose, "A pose is no rigid motion, or puts the object where it cannot be seen.")
      .value("image", ErrorCode::image, "A frame has the wrong size, format or memory.")
      .value("device", ErrorCode::device, "There is no OpenCL device, or a call to it failed.")
      .value("renderer", ErrorCode::renderer, "OpenGL (OSMesa, EGL) cannot be loaded or does not render.")
      .value("file", ErrorCode::file, "An input file is missing or cannot be read.")
      .value("output", ErrorCode::output, "A file cannot be written.");

  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& error) {
      const nb::object type = nb::module_::import_("holdfast.errors").attr("Error");
      const nb::object instance = type(error.what(), error.code());
      PyErr_SetObject(type.ptr(), instance.ptr());
    }
  });
}

}  // namespace holdfast::python
