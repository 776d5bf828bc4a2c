#include "holdfast/device.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <new>

#include "bindings.hpp"
#include "one_process.hpp"
#include "values.hpp"

namespace holdfast::python {

namespace nb = nanobind;

void bind_device(nb::module_& module) {
  nb::enum_<Partition>(module, "Partition", "How kernels divide their work.")
      .value("automatic", Partition::automatic, "strips on CPUs that have vector registers, groups elsewhere.")
      .value("strips", Partition::strips, "One work-item a tile, wide vectors: for CPUs.")
      .value("groups", Partition::groups, "One work-group a tile: for GPUs.");
  nb::enum_<RendererChoice>(module, "RendererChoice", "Which OpenGL draws the model.")
      .value("automatic", RendererChoice::automatic, "OSMesa, else EGL.")
      .value("osmesa", RendererChoice::osmesa)
      .value("egl", RendererChoice::egl);
  nb::class_<DeviceInfo> info_class(module, "DeviceInfo", "What an OpenCL device is.");
  info_class.def_ro("platform", &DeviceInfo::platform)
      .def_ro("name", &DeviceInfo::name)
      .def_ro("version", &DeviceInfo::version, "OpenCL version.")
      .def_ro("driver", &DeviceInfo::driver)
      .def_ro("type", &DeviceInfo::type, "'cpu', 'gpu', 'accelerator' or 'other'.")
      .def_ro("compute_units", &DeviceInfo::compute_units)
      .def_ro("platform_index", &DeviceInfo::platform_index)
      .def_ro("device_index", &DeviceInfo::device_index, "Within its platform.")
      .def_ro("usable", &DeviceInfo::usable)
      .def_ro("reason", &DeviceInfo::reason, "Why it is not usable, or why it was chosen.")
      .def("__repr__", [](const DeviceInfo& info) {
        return "<DeviceInfo " + std::to_string(info.platform_index) + ":" + std::to_string(info.device_index) + " " +
               info.name + (info.usable ? ">" : ", not usable>");
      });
  make_value(info_class, &DeviceInfo::platform, &DeviceInfo::platform_version, &DeviceInfo::name, &DeviceInfo::version,
             &DeviceInfo::driver, &DeviceInfo::type, &DeviceInfo::compute_units, &DeviceInfo::platform_index,
             &DeviceInfo::device_index, &DeviceInfo::usable, &DeviceInfo::reason);
  nb::class_<Device> device_class(
      module, "Device", nb::type_slots(kCheckedCalls),
      "An OpenCL device with Holdfast's kernels. Trackers that are given the same one share its queue; "
      "trackers in different threads are faster with one each.");
  device_class
      .def(
          "__init__",
          [](Device* self, const std::string& device, Partition partition, const std::filesystem::path& cache_folder,
             RendererChoice renderer) {
            require_one_process();
            const nb::gil_scoped_release unlocked;
            new (self) Device(DeviceOptions{device, partition, cache_folder, renderer});
          },
          nb::arg("device") = "", nb::arg("partition") = Partition::automatic, nb::arg("cache_folder") = "",
          nb::arg("renderer") = RendererChoice::automatic,
          "device: 'cpu', 'gpu', 'P:D' (platform and device index) or a part of a name; '': HOLDFAST_DEVICE, else a "
          "CPU. "
          "cache_folder: of compiled kernels; '': HOLDFAST_CACHE_DIR, else ~/.cache/holdfast.")
      .def_prop_ro("info", &Device::info, nb::rv_policy::copy);
  make_unique_here(device_class);
  module.def(
      "devices",
      [] {
        require_one_process();
        return Device::list();
      },
      "All OpenCL devices of this machine, usable or not.");
}

}  // namespace holdfast::python
