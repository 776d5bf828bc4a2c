#pragma once

#include <nanobind/nanobind.h>

/// The parts of the extension module, one a file.
namespace holdfast::python {

/// The caller of a function of the package, for warnings: arguments.py stands between.
inline constexpr int kCaller = 2;

/// Makes calls of a class run its `__init__`, which arguments.py replaces, and not nanobind's way past it.
inline const PyType_Slot kCheckedCalls[] = {{82 /* Py_tp_vectorcall, which older headers lack */, nullptr},
                                            {0, nullptr}};

void bind_error(nanobind::module_& module);
void bind_camera(nanobind::module_& module);
void bind_mesh(nanobind::module_& module);
void bind_device(nanobind::module_& module);
void bind_frame_result(nanobind::module_& module);
void bind_tracker(nanobind::module_& module);
void bind_renderer(nanobind::module_& module);
void bind_files(nanobind::module_& module);
void bind_video(nanobind::module_& module);
void bind_simulation(nanobind::module_& module);
void bind_baking(nanobind::module_& module);
void bind_evaluation(nanobind::module_& module);

}  // namespace holdfast::python
