#include "holdfast/device.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <future>
#include <initializer_list>
#include <memory>

#include "device/device_impl.hpp"
#include "device/embedded_text.hpp"
#include "device/program_cache.hpp"
#include "device/shared.h"
#include "device/zeroed_memory.hpp"

namespace holdfast {
namespace {

struct Candidate {
  cl::Device device;
  DeviceInfo info;
};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string without_trailing_space(std::string text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

DeviceInfo describe(const cl::Platform& platform, const cl::Device& device) {
  DeviceInfo info;
  info.platform = without_trailing_space(platform.getInfo<CL_PLATFORM_NAME>());
  info.platform_version = without_trailing_space(platform.getInfo<CL_PLATFORM_VERSION>());
  info.name = without_trailing_space(device.getInfo<CL_DEVICE_NAME>());
  info.version = without_trailing_space(device.getInfo<CL_DEVICE_VERSION>());
  info.driver = without_trailing_space(device.getInfo<CL_DRIVER_VERSION>());
  const auto type = device.getInfo<CL_DEVICE_TYPE>();
  info.type = (type & CL_DEVICE_TYPE_CPU)           ? "cpu"
              : (type & CL_DEVICE_TYPE_GPU)         ? "gpu"
              : (type & CL_DEVICE_TYPE_ACCELERATOR) ? "accelerator"
                                                    : "other";
  info.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  if (!device.getInfo<CL_DEVICE_AVAILABLE>()) {
    info.reason = "the driver says it is not available";
  } else if (!device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>()) {
    info.reason = "it has no kernel compiler";
  } else if (device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>() < HF_GROUP) {
    info.reason = "its work-groups are too small";
  } else if (!device.getInfo<CL_DEVICE_ENDIAN_LITTLE>()) {
    info.reason = "it is big-endian";
  }
  info.usable = info.reason.empty();
  return info;
}

/// Every device of every platform. Some drivers answer only to an explicit type, and platforms without devices may be
/// listed first: each type of each platform is asked for.
std::vector<Candidate> enumerate() {
  std::vector<Candidate> found;
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error&) {
    return found;
  }
  for (std::size_t p = 0; p < platforms.size(); ++p) {
    std::vector<cl::Device> devices;
    for (const cl_device_type type : std::initializer_list<cl_device_type>{
             CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU, CL_DEVICE_TYPE_ACCELERATOR}) {
      std::vector<cl::Device> of_type;
      try {
        platforms[p].getDevices(type, &of_type);
      } catch (const cl::Error&) {
        continue;
      }
      for (const auto& device : of_type) {
        const bool known =
            std::any_of(devices.begin(), devices.end(), [&](const cl::Device& other) { return other() == device(); });
        if (!known) devices.push_back(device);
      }
    }
    for (std::size_t d = 0; d < devices.size(); ++d) {
      try {
        Candidate candidate{devices[d], describe(platforms[p], devices[d])};
        candidate.info.platform_index = static_cast<int>(p);
        candidate.info.device_index = static_cast<int>(d);
        found.push_back(std::move(candidate));
      } catch (const cl::Error&) {
        continue;
      }
    }
  }
  return found;
}

bool matches(const DeviceInfo& info, const std::string& wanted) {
  if (wanted == info.type) return true;
  if (wanted == std::to_string(info.platform_index) + ":" + std::to_string(info.device_index)) return true;
  return lower(info.platform).find(wanted) != std::string::npos || lower(info.name).find(wanted) != std::string::npos;
}

std::string listing(const std::vector<Candidate>& candidates) {
  std::string text;
  for (const auto& candidate : candidates) {
    text += (text.empty() ? "" : ", ") + std::to_string(candidate.info.platform_index) + ":" +
            std::to_string(candidate.info.device_index) + " '" + candidate.info.name + "' (" + candidate.info.type +
            ", " + candidate.info.platform + (candidate.info.usable ? "" : "; not usable: " + candidate.info.reason) +
            ")";
  }
  return text;
}

/// The wanted device's index, or the default's; sets the chosen one's reason. Throws Error(device).
std::size_t choose(std::vector<Candidate>& candidates, const std::string& option) {
  if (candidates.empty()) {
    if (const auto folder = unwritable_pocl_cache()) {
      throw Error(ErrorCode::device, "no OpenCL device found; PoCL has none where it cannot write to its cache, '" +
                                         folder->string() + "': make room there, or set POCL_CACHE_DIR to a folder " +
                                         "that can be written");
    }
    throw Error(ErrorCode::device,
                "no OpenCL device found; install a driver, for example Debian's package pocl-opencl-icd for the CPU");
  }
  const char* variable = std::getenv("HOLDFAST_DEVICE");
  const bool by_option = !option.empty();
  const std::string wanted = lower(by_option ? option : variable != nullptr ? variable : "");
  if (!wanted.empty()) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (candidates[i].info.usable && matches(candidates[i].info, wanted)) {
        candidates[i].info.reason = by_option ? "chosen by option" : "chosen by HOLDFAST_DEVICE";
        return i;
      }
    }
    throw Error(ErrorCode::device, "no usable OpenCL device matches '" + wanted + "' (from " +
                                       (by_option ? "the device option" : "HOLDFAST_DEVICE") +
                                       "); there is: " + listing(candidates));
  }
  for (const bool any_type : {false, true}) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (candidates[i].info.usable && (any_type || candidates[i].info.type == "cpu")) {
        candidates[i].info.reason =
            any_type ? "the first usable device; there is no CPU device" : "the first CPU device";
        return i;
      }
    }
  }
  throw Error(ErrorCode::device, "no OpenCL device is usable: " + listing(candidates));
}

/// Begins to load the kernels, or to compile them: in a thread of its own, or when they are first needed.
void begin_program(Device::Impl& impl, const DeviceOptions& options, std::launch when) {
  // A CPU driver without vectors of its own (rusticl, Oclgrind) would compile wide ones for minutes.
  const bool wide_cpu = impl.info.type == "cpu" && impl.device.getInfo<CL_DEVICE_PREFERRED_VECTOR_WIDTH_FLOAT>() > 1;
  impl.strips = options.partition == Partition::automatic ? wide_cpu : options.partition == Partition::strips;
  std::string source;
  for (const char* file : {"shared.h", "common.cl", "device_image.cl", "image_filter.cl", "blur_block.cl",
                           "halve_frame.cl", "view_template.cl", "motion_blur.cl", "occlusion.cl",
                           "flow_constraints.cl", "shift_search.cl", "contour_constraints.cl", "edge_candidates.cl"}) {
    source += embedded_text(file);
    source += '\n';
  }
  // -w: without 512-bit registers PoCL has its compiler warn of vectors as arguments, on standard error.
  const std::string build_options = std::string("-w -cl-std=CL1.2 -DHF_STRIPS=") + (impl.strips ? "1" : "0");
  // The thread holds the handles that it needs, so that nothing which it looks at goes before it does.
  impl.program = std::async(when, [cache = ProgramCache(options.cache_folder), context = impl.context,
                                   device = impl.device, source, build_options] {
                   return cache.build(context, device, source, build_options);
                 }).share();
}

}  // namespace

cl::Buffer Device::Impl::zeroed_buffer(std::size_t bytes) const {
  if (info.type != "cpu") {
    cl::Buffer buffer(context, CL_MEM_READ_WRITE, bytes);
    queue.enqueueFillBuffer(buffer, cl_uchar{0}, 0, bytes);
    return buffer;
  }
  // On a CPU device the buffer lies in memory that the system hands out as zero, a page at a time, when it is touched:
  // what the object never covers costs nothing.
  auto memory = std::make_unique<ZeroedMemory>(bytes);
  cl::Buffer buffer(context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory->data());
  buffer.setDestructorCallback([](cl_mem, void* owned) { delete static_cast<ZeroedMemory*>(owned); }, memory.get());
  memory.release();
  return buffer;
}

HostMemory Device::Impl::host_memory(std::size_t bytes) const { return {context, queue, bytes, info.type != "cpu"}; }

void Device::Impl::enqueue_rows(const cl::Kernel& kernel, int width, int height) const {
  if (width <= 0 || height <= 0) return;
  // Fixed local sizes: a driver may compile once for each new one. Items beyond the width do nothing.
  const std::size_t group = strips ? 1 : HF_GROUP, columns = strips ? 1 : static_cast<std::size_t>(width);
  queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                             cl::NDRange((columns + group - 1) / group * group, static_cast<std::size_t>(height)),
                             cl::NDRange(group, 1));
}

void Device::Impl::enqueue_items(const cl::Kernel& kernel, std::size_t count) const {
  const std::size_t group = strips ? 1 : HF_GROUP;
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange((count + group - 1) / group * group),
                             cl::NDRange(group));
}

void Device::Impl::enqueue_tiles(const cl::Kernel& kernel, int tiles_x, int tiles_y) const {
  if (tiles_x <= 0 || tiles_y <= 0) return;
  const std::size_t items = strips ? 1 : HF_GROUP;
  queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                             cl::NDRange(items * static_cast<std::size_t>(tiles_x), static_cast<std::size_t>(tiles_y)),
                             cl::NDRange(items, 1));
}

Device::Device(const DeviceOptions& options) : impl_(std::make_shared<Impl>()) {
  impl_->renderer = options.renderer;
  auto candidates = enumerate();
  const std::size_t chosen = choose(candidates, options.device);
  impl_->device = candidates[chosen].device;
  impl_->info = candidates[chosen].info;
  with_device_errors("opening the device", [&] {
    impl_->context = cl::Context(impl_->device);
    impl_->queue = cl::CommandQueue(impl_->context, impl_->device);
    begin_program(*impl_, options, std::launch::async);
  });
}

Device::Device(_cl_context* context, _cl_command_queue* queue, const DeviceOptions& options)
    : impl_(std::make_shared<Impl>()) {
  impl_->renderer = options.renderer;
  if (context == nullptr || queue == nullptr) {
    throw Error(ErrorCode::invalid_argument, "Device: the OpenCL context and the command queue must not be null");
  }
  with_device_errors("using the caller's context and queue", [&] {
    impl_->context = cl::Context(context, true);
    impl_->queue = cl::CommandQueue(queue, true);
    if (impl_->queue.getInfo<CL_QUEUE_CONTEXT>()() != context) {
      throw Error(ErrorCode::invalid_argument, "Device: the command queue belongs to another context");
    }
    if (impl_->queue.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) {
      throw Error(ErrorCode::invalid_argument, "Device: the command queue is out of order; pass an in-order queue");
    }
    impl_->device = impl_->queue.getInfo<CL_QUEUE_DEVICE>();
    impl_->info = describe(cl::Platform(impl_->device.getInfo<CL_DEVICE_PLATFORM>()), impl_->device);
    if (!impl_->info.usable) {
      throw Error(ErrorCode::device,
                  "the caller's device '" + impl_->info.name + "' cannot be used: " + impl_->info.reason);
    }
    impl_->info.reason = "the caller's";
    // Nobody else's context is used behind their back.
    begin_program(*impl_, options, std::launch::deferred);
    impl_->program.wait();
  });
}

const DeviceInfo& Device::info() const { return impl_->info; }

std::vector<DeviceInfo> Device::list() {
  auto candidates = enumerate();
  try {
    if (!candidates.empty()) choose(candidates, "");
  } catch (const Error&) {
    // Nothing to choose; the list says why.
  }
  std::vector<DeviceInfo> infos;
  for (auto& candidate : candidates) infos.push_back(std::move(candidate.info));
  return infos;
}

}  // namespace holdfast
