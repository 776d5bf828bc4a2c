#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/export.hpp"
#include "holdfast/renderer_choice.hpp"

/// OpenCL's handles, declared so that no OpenCL header is needed here.
struct _cl_context;
struct _cl_command_queue;

namespace holdfast {

struct DeviceInfo {
  std::string platform;          ///< platform name
  std::string platform_version;  ///< for example "OpenCL 3.0 PoCL 3.1"
  std::string name;              ///< device name
  std::string version;           ///< device's OpenCL version
  std::string driver;            ///< driver version
  std::string type;              ///< "cpu", "gpu", "accelerator" or "other"
  unsigned compute_units = 0;
  int platform_index = 0;
  int device_index = 0;  ///< within its platform
  bool usable = true;    ///< false where the device lacks what Holdfast needs
  std::string reason;    ///< why it is not usable, or why it was chosen
};

/// How kernels divide their work (results agree within the tolerance in docs/architecture.md).
enum class Partition {
  automatic,  ///< strips on CPU devices that have vector registers, groups elsewhere
  strips,     ///< one work-item a tile, wide explicit vectors, private sums
  groups,     ///< one work-group a tile, a local-memory tree
};

struct DeviceOptions {
  /// "cpu", "gpu", "P:D" (platform and device index), or a part of the platform's or device's name, any case.
  /// Empty: the environment variable HOLDFAST_DEVICE, else a CPU device, else the first that is usable.
  std::string device;
  Partition partition = Partition::automatic;
  /// Folder of compiled kernels; empty: default_cache_folder(). A folder that cannot be written costs compiling again,
  /// nothing else.
  std::filesystem::path cache_folder;
  RendererChoice renderer = RendererChoice::automatic;  ///< of trackers on this device
};

/// The folder of what is made once a machine: HOLDFAST_CACHE_DIR, else XDG_CACHE_HOME/holdfast, else ~/.cache/holdfast;
/// empty where none of these variables is set.
HOLDFAST_EXPORT std::filesystem::path default_cache_folder();

/// The folder where PoCL keeps what it compiles (POCL_CACHE_DIR, else below XDG_CACHE_HOME or HOME), where that cannot
/// be written or is full: PoCL then finds no device or compiles nothing. Nothing where all is well. Tries to write
/// there.
HOLDFAST_EXPORT std::optional<std::filesystem::path> unwritable_pocl_cache();

/// An OpenCL device with context, in-order queue and Holdfast's compiled kernels. Copies share them.
class HOLDFAST_EXPORT Device {
 public:
  /// Throws Error(device) when there is no usable device or the wanted one is missing; the message lists what there is.
  /// The first of a process loads the drivers, and PoCL changes the environment then: no other thread may read it.
  /// Kernels are loaded, or compiled the first time, in a thread: what fails there, Tracker's constructor throws.
  explicit Device(const DeviceOptions& options = {});

  /// Works on a caller's context and in-order queue; both are retained for as long as Holdfast uses them. The kernels
  /// are ready when it returns. Throws Error(invalid_argument) or Error(device) for what cannot be used.
  Device(_cl_context* context, _cl_command_queue* queue, const DeviceOptions& options = {});

  const DeviceInfo& info() const;

  /// Every device of every platform, usable or not; empty when no OpenCL platform is installed. Never throws.
  static std::vector<DeviceInfo> list();

  struct Impl;
  Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

}  // namespace holdfast
