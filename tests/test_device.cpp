// Devices: which one is chosen and why, a caller's own context and queue, and the cache of compiled kernels.
// Runs on the device that HOLDFAST_DEVICE names (the default without it), whatever implementation it belongs to.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <future>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "device/device_impl.hpp"
#include "device/shared.h"
#include "device/zeroed_memory.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"
#include "image/image_filter.hpp"
#include "support/files.hpp"
#include "support/kernel_checks.hpp"

using namespace holdfast;
using namespace holdfast::test;

namespace {

/// Sets or (nullopt) unsets an environment variable, and puts it back.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::optional<std::string>& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }
  ~ScopedVariable() { set(before_); }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  void set(const std::optional<std::string>& value) {
    if (value) {
      setenv(name_, value->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }

  const char* name_;
  std::optional<std::string> before_;
};

std::string address(const DeviceInfo& info) {
  return std::to_string(info.platform_index) + ":" + std::to_string(info.device_index);
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Runs a kernel: a grey frame of 40 x 3 pixels to level 0. True when all pixels come out as value / 255, coverage 1.
bool converts_a_frame(const Device& device) {
  constexpr int width = 40, height = 3;
  const Device::Impl& impl = device.impl();
  std::vector<cl_uchar> frame(width * height);
  for (std::size_t i = 0; i < frame.size(); ++i) frame[i] = static_cast<cl_uchar>(2 * i);
  kernel::hf_frame parameters{};
  parameters.width = width;
  parameters.height = height;
  parameters.stride = width;
  const kernel::hf_rect rect{0, 0, width, height};
  const kernel::hf_layout layout{width, 0};
  const std::size_t out_bytes = HF_PIXEL * sizeof(float) * frame.size();
  const cl::Buffer in = impl.zeroed_buffer(frame.size()), out = impl.zeroed_buffer(out_bytes);
  impl.queue.enqueueWriteBuffer(in, CL_TRUE, 0, frame.size(), frame.data());
  cl::Kernel convert = impl.kernel("convert_grey8");
  set_arguments(convert, in, parameters, rect, layout, out);
  impl.enqueue_rows(convert, width, height);
  std::vector<float> pixels(HF_PIXEL * frame.size());
  impl.queue.enqueueReadBuffer(out, CL_TRUE, 0, out_bytes, pixels.data());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const float* pixel = &pixels[HF_PIXEL * i];
    if (std::abs(pixel[0] - static_cast<float>(frame[i]) / 255.0F) > 1e-6F) return false;
    if (pixel[1] != 0.0F || pixel[2] != 0.0F || pixel[3] != 1.0F) return false;
  }
  return true;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// A context and an in-order queue as a caller would own them, on the device under test.
struct CallersQueue {
  explicit CallersQueue(cl_command_queue_properties properties = 0) {
    const cl_device_id device = Device().impl().device();
    cl_int status = CL_SUCCESS;
    context = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &status);
    REQUIRE(status == CL_SUCCESS);
    queue = clCreateCommandQueue(context, device, properties, &status);
    REQUIRE(status == CL_SUCCESS);
  }
  ~CallersQueue() { release(); }
  CallersQueue(const CallersQueue&) = delete;
  CallersQueue& operator=(const CallersQueue&) = delete;

  void release() {
    if (queue != nullptr) clReleaseCommandQueue(queue);
    if (context != nullptr) clReleaseContext(context);
    queue = nullptr;
    context = nullptr;
  }
  cl_uint queue_references() const {
    cl_uint count = 0;
    REQUIRE(clGetCommandQueueInfo(queue, CL_QUEUE_REFERENCE_COUNT, sizeof(count), &count, nullptr) == CL_SUCCESS);
    return count;
  }

  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
};

}  // namespace

TEST_CASE("list: every device once, with its names; one of them is the default") {
  const ScopedVariable unset("HOLDFAST_DEVICE", std::nullopt);
  const auto devices = Device::list();
  REQUIRE(!devices.empty());
  std::set<std::string> addresses;
  int chosen = 0;
  for (const DeviceInfo& info : devices) {
    CAPTURE(info.name);
    CHECK(addresses.insert(address(info)).second);
    CHECK(!info.name.empty());
    CHECK(!info.platform.empty());
    CHECK(info.platform_version.starts_with("OpenCL "));
    CHECK(info.version.starts_with("OpenCL "));
    CHECK(info.compute_units > 0);
    CHECK(std::set<std::string>{"cpu", "gpu", "accelerator", "other"}.count(info.type) == 1);
    CHECK((info.usable || !info.reason.empty()));
    if (info.usable && !info.reason.empty()) ++chosen;
  }
  CHECK(chosen == 1);
}

TEST_CASE("default: a CPU device where there is one") {
  const ScopedVariable unset("HOLDFAST_DEVICE", std::nullopt);
  const auto devices = Device::list();
  const bool any_cpu =
      std::any_of(devices.begin(), devices.end(), [](const DeviceInfo& d) { return d.usable && d.type == "cpu"; });
  const Device device;
  CHECK((device.info().type == "cpu") == any_cpu);
  CHECK(device.info().reason.find("the first") != std::string::npos);
  CHECK(converts_a_frame(device));
}

TEST_CASE("a device is found by its address, its type, and parts of its own and its platform's name in any case") {
  const DeviceInfo wanted = Device().info();
  for (const std::string& option :
       {address(wanted), wanted.name, upper(wanted.name), wanted.name.substr(1, 5), upper(wanted.platform)}) {
    CAPTURE(option);
    const Device device(DeviceOptions{.device = option, .cache_folder = {}});
    CHECK(device.info().reason == "chosen by option");
    CHECK(address(device.info()) == address(wanted));
  }
  CHECK(Device(DeviceOptions{.device = wanted.type, .cache_folder = {}}).info().type == wanted.type);
}

TEST_CASE("HOLDFAST_DEVICE chooses; the option goes before it; empty is as unset") {
  const DeviceInfo wanted = Device().info();
  {
    const ScopedVariable named("HOLDFAST_DEVICE", address(wanted));
    CHECK(Device().info().reason == "chosen by HOLDFAST_DEVICE");
    CHECK(address(Device().info()) == address(wanted));
  }
  {
    const ScopedVariable missing("HOLDFAST_DEVICE", "no such device");
    CHECK(error_of([] { Device(); }).says(ErrorCode::device, {"no such device", "HOLDFAST_DEVICE"}));
    CHECK(Device(DeviceOptions{.device = address(wanted), .cache_folder = {}}).info().reason == "chosen by option");
    CHECK(!Device::list().empty());  // never throws
  }
  const ScopedVariable empty("HOLDFAST_DEVICE", "");
  CHECK(Device().info().reason.find("the first") != std::string::npos);
}

TEST_CASE("an unknown device: one line that names it, where it was asked for, and what there is") {
  const DeviceInfo present = Device().info();
  const std::string address_of_present = address(present);
  const auto error = error_of([] { Device(DeviceOptions{.device = "Abacus 3000", .cache_folder = {}}); });
  CHECK(error.says(ErrorCode::device, {"abacus 3000", "device option", present.name.c_str(), present.platform.c_str(),
                                       address_of_present.c_str()}));
  CHECK(
      error_of([] { Device(DeviceOptions{.device = "99:0", .cache_folder = {}}); }).says(ErrorCode::device, {"99:0"}));
}

// Needs an ICD loader that sees no platform: CTest runs it with OCL_ICD_VENDORS naming an empty folder.
TEST_CASE("without any platform: an empty list, and an error that names the package to install" * doctest::skip()) {
  CHECK(Device::list().empty());
  CHECK(error_of([] { Device(); }).says(ErrorCode::device, {"no OpenCL device", "pocl-opencl-icd"}));
}

TEST_CASE("a caller's context and queue are retained: work goes on after the caller released them") {
  CallersQueue callers;
  const cl_uint before = callers.queue_references();
  {
    const Device device(callers.context, callers.queue);
    CHECK(callers.queue_references() > before);
    CHECK(device.impl().queue() == callers.queue);
    CHECK(device.impl().context() == callers.context);
    CHECK(device.info().reason == "the caller's");
    // No thread is still at work in it.
    CHECK(device.impl().program.wait_for(std::chrono::seconds(0)) == std::future_status::ready);
  }
  CHECK(callers.queue_references() == before);  // nothing of it is kept either

  const Device device(callers.context, callers.queue);
  callers.release();
  CHECK(converts_a_frame(device));
}

TEST_CASE("kernels that do not compile are said by every stage that asks for one") {
  const Device device;
  std::promise<cl::Program> program;
  program.set_exception(std::make_exception_ptr(Error(ErrorCode::device, "a kernel does not compile")));
  device.impl().program = program.get_future().share();
  for (int time = 0; time < 2; ++time) {
    CHECK(error_of([&] { ImageFilter(device.impl()); }).says(ErrorCode::device, {"a kernel does not compile"}));
  }
}

TEST_CASE("copies of a device share its context") {
  std::optional<Device> first(std::in_place);
  const Device second = *first;
  CHECK(&second.impl() == &first->impl());
  first.reset();
  CHECK(converts_a_frame(second));
}

TEST_CASE("a caller's queue that cannot serve is refused") {
  const CallersQueue mine, other;
  CHECK(error_of([&] { Device(nullptr, mine.queue); }).says(ErrorCode::invalid_argument, {"context", "null"}));
  CHECK(error_of([&] { Device(mine.context, nullptr); }).says(ErrorCode::invalid_argument, {"queue", "null"}));
  CHECK(error_of([&] {
          Device(mine.context, other.queue);
        }).says(ErrorCode::invalid_argument, {"queue", "another context"}));
  const auto properties = Device().impl().device.getInfo<CL_DEVICE_QUEUE_PROPERTIES>();
  if (properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) {
    const CallersQueue unordered(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    CHECK(error_of([&] {
            Device(unordered.context, unordered.queue);
          }).says(ErrorCode::invalid_argument, {"out of order"}));
  }
}

TEST_CASE("both partitions compile and run, whatever the device") {
  for (const Partition partition : {Partition::strips, Partition::groups}) {
    const Device device(DeviceOptions{.device = {}, .partition = partition, .cache_folder = {}});
    CHECK(device.impl().strips == (partition == Partition::strips));
    CHECK(converts_a_frame(device));
    CHECK(device.impl().program.get().getInfo<CL_PROGRAM_NUM_KERNELS>() >=
          12);  // six formats, and one a stage at least
  }
  const Device device;
  const Device::Impl& by_default = device.impl();
  const bool vectors = by_default.device.getInfo<CL_DEVICE_PREFERRED_VECTOR_WIDTH_FLOAT>() > 1;
  CHECK(by_default.strips == (by_default.info.type == "cpu" && vectors));
}

TEST_CASE("program cache: a cold start writes one file, a warm start reads it, partitions do not mix") {
  const TemporaryFolder folder;
  const DeviceOptions options{
      .device = {}, .partition = Partition::groups, .cache_folder = folder.path() / "new" / "cache"};
  CHECK(converts_a_frame(Device(options)));
  auto files = files_in(options.cache_folder);
  REQUIRE(files.size() == 1);
  REQUIRE(std::filesystem::file_size(files[0]) > 0);

  // A start that compiles writes the file anew: an untouched time of change shows that it was read.
  const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(24);
  std::filesystem::last_write_time(files[0], long_ago);
  const auto written = std::filesystem::last_write_time(files[0]);
  CHECK(converts_a_frame(Device(options)));
  CHECK(files_in(options.cache_folder) == files);
  CHECK(std::filesystem::last_write_time(files[0]) == written);

  DeviceOptions strips = options;
  strips.partition = Partition::strips;
  CHECK(converts_a_frame(Device(strips)));
  CHECK(files_in(options.cache_folder).size() == 2);
}

TEST_CASE("program cache: damaged files are compiled anew and replaced") {
  const TemporaryFolder folder;
  const DeviceOptions options{.device = {}, .partition = Partition::groups, .cache_folder = folder.path()};
  CHECK(converts_a_frame(Device(options)));
  const auto files = files_in(folder.path());
  REQUIRE(files.size() == 1);
  const std::string good = read_file(files[0]);
  std::string flipped = good;
  for (std::size_t i = good.size() / 2; i < good.size() / 2 + 64 && i < good.size(); ++i) flipped[i] ^= '\x55';
  const std::vector<std::pair<const char*, std::string>> damages = {
      {"empty", ""},
      {"text", "this is no compiled kernel"},
      {"first half", good.substr(0, good.size() / 2)},
      {"last byte missing", good.substr(0, good.size() - 1)},
      {"bytes flipped in the middle", flipped},
      {"zeros", std::string(good.size(), '\0')}};
  for (const auto& [name, bytes] : damages) {
    CAPTURE(name);
    write_bytes(files[0], bytes);
    CHECK(converts_a_frame(Device(options)));
    CHECK(read_file(files[0]) != bytes);
    CHECK(files_in(folder.path()).size() == 1);
  }
}

TEST_CASE("program cache: a folder that cannot be written costs nothing but compiling") {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "not a folder");
  CHECK(converts_a_frame(Device(DeviceOptions{.device = {}, .cache_folder = file / "cache"})));
  CHECK(read_file(file) == "not a folder");
  const DeviceOptions taken{.device = {}, .cache_folder = folder / "taken"};
  CHECK(converts_a_frame(Device(taken)));
  const auto compiled = files_in(taken.cache_folder);
  REQUIRE(compiled.size() == 1);
  std::filesystem::remove(compiled[0]);
  std::filesystem::create_directory(compiled[0]);  // where the file belongs
  CHECK(converts_a_frame(Device(taken)));
  CHECK(std::filesystem::is_directory(compiled[0]));
  CHECK(files_in(taken.cache_folder) == compiled);
  if (geteuid() != 0) {  // permissions do not stop root
    const auto locked = folder / "locked";
    std::filesystem::create_directory(locked);
    std::filesystem::permissions(locked, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    CHECK(converts_a_frame(Device(DeviceOptions{.device = {}, .cache_folder = locked})));
    CHECK(files_in(locked).empty());
    std::filesystem::permissions(locked, std::filesystem::perms::owner_all);
  }
}

TEST_CASE(
    "program cache: the folder comes from the option, HOLDFAST_CACHE_DIR, XDG_CACHE_HOME or HOME, in this order") {
  const TemporaryFolder folder;
  const ScopedVariable home("HOME", (folder / "home").string());
  const ScopedVariable xdg("XDG_CACHE_HOME", (folder / "xdg").string());
  const ScopedVariable holdfast("HOLDFAST_CACHE_DIR", (folder / "holdfast").string());
  const auto has_cache = [&](const char* path) {
    const auto where = folder.path() / path;
    return std::filesystem::is_directory(where) && files_in(where).size() == 1;
  };
  Device(DeviceOptions{.device = {}, .cache_folder = folder / "option"});
  CHECK(has_cache("option"));
  CHECK(!has_cache("holdfast"));
  Device();
  CHECK(has_cache("holdfast"));
  CHECK(!has_cache("xdg/holdfast"));
  {
    const ScopedVariable no_holdfast("HOLDFAST_CACHE_DIR", std::nullopt);
    Device();
    CHECK(has_cache("xdg/holdfast"));
    CHECK(!has_cache("home/.cache/holdfast"));
    const ScopedVariable no_xdg("XDG_CACHE_HOME", std::nullopt);
    Device();
    CHECK(has_cache("home/.cache/holdfast"));
  }
}

TEST_CASE("memory of buffers is zero from a page's start to its end, and can be written to its end") {
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{4097}, std::size_t{3} << 20}) {
    CAPTURE(bytes);
    const ZeroedMemory memory(bytes);
    CHECK(reinterpret_cast<std::uintptr_t>(memory.data()) % 4096 == 0);
    auto* const begin = static_cast<unsigned char*>(memory.data());
    CHECK(std::all_of(begin, begin + bytes, [](unsigned char byte) { return byte == 0; }));
    std::fill(begin, begin + bytes, static_cast<unsigned char>(255));
    CHECK(begin[bytes - 1] == 255);
  }
}

TEST_CASE("the host's memory for copies, page-locked or not: zeros, and what is copied through it arrives") {
  const Device device;
  const Device::Impl& impl = device.impl();
  for (const bool page_locked : {false, true}) {
    CAPTURE(page_locked);
    constexpr std::size_t kCount = 5001;
    const HostMemory from(impl.context, impl.queue, kCount * sizeof(int), page_locked);
    const HostMemory to(impl.context, impl.queue, kCount * sizeof(int), page_locked);
    auto* const numbers = from.as<int>();
    CHECK(std::all_of(numbers, numbers + kCount, [](int number) { return number == 0; }));
    std::iota(numbers, numbers + kCount, 7);
    const cl::Buffer buffer(impl.context, CL_MEM_READ_WRITE, kCount * sizeof(int));
    impl.queue.enqueueWriteBuffer(buffer, CL_FALSE, 0, kCount * sizeof(int), from.data());
    impl.queue.enqueueReadBuffer(buffer, CL_TRUE, 0, kCount * sizeof(int), to.data());
    CHECK(std::equal(numbers, numbers + kCount, to.as<int>()));
  }
}
