#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "render/gl_context.hpp"
#include "render/gl_library.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {
namespace {

// What Holdfast uses of EGL 1.5 (Khronos' registry), declared here: no package is needed to build.
using Handle = void*;
using Boolean = unsigned int;
using Enum = unsigned int;
using VoidFunction = void (*)();

constexpr std::int32_t kExtensions = 0x3055;
constexpr std::int32_t kNone = 0x3038;
constexpr std::int32_t kSurfaceType = 0x3033, kRenderableType = 0x3040, kOpenGlBit = 0x0008;
constexpr std::int32_t kMajorVersion = 0x3098, kMinorVersion = 0x30FB, kProfileMask = 0x30FD, kCoreProfile = 0x0001;
constexpr std::int32_t kDrawSurface = 0x3059, kReadSurface = 0x305A;
constexpr Enum kOpenGlApi = 0x30A2;
constexpr Enum kPlatformDevice = 0x313F, kPlatformSurfaceless = 0x31DD;

/// EGL's functions, of the library that hands them out.
struct Egl {
  VoidFunction (*get_address)(const char* name);
  const char* (*query_string)(Handle display, std::int32_t name);
  Boolean (*initialize)(Handle display, std::int32_t* major, std::int32_t* minor);
  Boolean (*bind_api)(Enum api);
  Enum (*query_api)();
  Boolean (*choose_config)(Handle display, const std::int32_t* attributes, Handle* configs, std::int32_t size,
                           std::int32_t* count);
  Handle (*create_context)(Handle display, Handle config, Handle share, const std::int32_t* attributes);
  Boolean (*destroy_context)(Handle display, Handle context);
  Boolean (*make_current)(Handle display, Handle draw, Handle read, Handle context);
  Handle (*current_context)();
  Handle (*current_display)();
  Handle (*current_surface)(std::int32_t which);
  std::int32_t (*get_error)();
  // Extensions, null where there is none.
  Handle (*platform_display)(Enum platform, void* native, const std::int32_t* attributes);
  Boolean (*query_devices)(std::int32_t most, Handle* devices, std::int32_t* count);
  const char* (*query_device_string)(Handle device, std::int32_t name);
};

Egl load_egl() {
  void* library = open_gl_library({"libEGL.so.1", "libEGL.so"});
  Egl egl{};
  const auto load = [&](auto& function, const char* name) {
    function = required_symbol<std::remove_reference_t<decltype(function)>>(library, name);
  };
  load(egl.get_address, "eglGetProcAddress");
  load(egl.query_string, "eglQueryString");
  load(egl.initialize, "eglInitialize");
  load(egl.bind_api, "eglBindAPI");
  load(egl.query_api, "eglQueryAPI");
  load(egl.choose_config, "eglChooseConfig");
  load(egl.create_context, "eglCreateContext");
  load(egl.destroy_context, "eglDestroyContext");
  load(egl.make_current, "eglMakeCurrent");
  load(egl.current_context, "eglGetCurrentContext");
  load(egl.current_display, "eglGetCurrentDisplay");
  load(egl.current_surface, "eglGetCurrentSurface");
  load(egl.get_error, "eglGetError");
  const auto extension = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(egl.get_address(name));
  };
  extension(egl.platform_display, "eglGetPlatformDisplayEXT");
  extension(egl.query_devices, "eglQueryDevicesEXT");
  extension(egl.query_device_string, "eglQueryDeviceStringEXT");
  return egl;
}

bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list != nullptr ? list : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// Displays that need no screen: graphics processors, what Mesa chooses, software; `on_cpu`: the other way round.
std::vector<Handle> displays_without_screen(const Egl& egl, bool on_cpu) {
  const char* client = egl.query_string(nullptr, kExtensions);
  std::vector<Handle> processors, chosen, software;
  if (egl.platform_display == nullptr) return {};
  std::int32_t count = 0;
  if (egl.query_devices != nullptr && egl.query_devices(0, nullptr, &count) != 0 && count > 0) {
    std::vector<Handle> devices(static_cast<std::size_t>(count));
    egl.query_devices(count, devices.data(), &count);
    devices.resize(static_cast<std::size_t>(std::max(count, 0)));
    for (Handle device : devices) {
      const bool draws_by_cpu = egl.query_device_string != nullptr &&
                                has_extension(egl.query_device_string(device, kExtensions), "EGL_MESA_device_software");
      (draws_by_cpu ? software : processors).push_back(egl.platform_display(kPlatformDevice, device, nullptr));
    }
  }
  if (has_extension(client, "EGL_MESA_platform_surfaceless")) {
    chosen.push_back(egl.platform_display(kPlatformSurfaceless, nullptr, nullptr));
  }
  std::vector<Handle> displays;
  for (const auto* some : {&processors, &chosen, &software})
    displays.insert(displays.end(), some->begin(), some->end());
  if (on_cpu) std::reverse(displays.begin(), displays.end());
  std::erase(displays, nullptr);
  return displays;
}

Handle context_on(const Egl& egl, Handle display) {
  // Displays are never terminated: other renderers, and the host, may have contexts on the same one.
  if (egl.initialize(display, nullptr, nullptr) == 0) return nullptr;
  if (!has_extension(egl.query_string(display, kExtensions), "EGL_KHR_surfaceless_context")) return nullptr;
  const std::array<std::int32_t, 5> wanted = {kSurfaceType, 0, kRenderableType, kOpenGlBit, kNone};
  Handle config = nullptr;
  std::int32_t count = 0;
  if (egl.choose_config(display, wanted.data(), &config, 1, &count) == 0 || count < 1) return nullptr;
  const std::array<std::int32_t, 7> attributes = {kMajorVersion, 3,    kMinorVersion, 3, kProfileMask,
                                                  kCoreProfile,  kNone};
  return egl.create_context(display, config, nullptr, attributes.data());
}

class EglContext final : public GlContext {
 public:
  explicit EglContext(bool on_cpu) : egl_(load_egl()) {
    const Enum api_before = egl_.query_api();
    if (egl_.bind_api(kOpenGlApi) == 0) fail_context("it knows OpenGL ES alone");
    const std::vector<Handle> displays = displays_without_screen(egl_, on_cpu);
    for (Handle display : displays) {
      display_ = display;
      context_ = context_on(egl_, display);
      if (context_ != nullptr) break;
    }
    egl_.bind_api(api_before);
    if (context_ == nullptr) {
      fail_context("none of its " + std::to_string(displays.size()) +
                   " displays without a screen makes an OpenGL 3.3 core context");
    }
    if (const char* missing = gl_.load(egl_.get_address)) {
      egl_.destroy_context(display_, context_);
      fail_context(std::string("it has no ") + missing);
    }
  }

  ~EglContext() override { egl_.destroy_context(display_, context_); }

  // The host may draw by EGL in this thread: its context is given back.
  void make_current() override {
    before_ = {egl_.current_display(), egl_.current_surface(kDrawSurface), egl_.current_surface(kReadSurface),
               egl_.current_context()};
    if (egl_.make_current(display_, nullptr, nullptr, context_) != 0) return;
    fail_rendering(ErrorCode::renderer,
                   "EGL cannot make its context current in this thread (error " + std::to_string(egl_.get_error()) +
                       "); where the program draws by GLX in the same thread, use Holdfast in another one");
  }

  void release() noexcept override {
    const auto& [display, draw, read, context] = before_;
    if (context == nullptr || egl_.make_current(display, draw, read, context) == 0) {
      egl_.make_current(display_, nullptr, nullptr, nullptr);
    }
  }

  const char* name() const override { return "EGL"; }

 private:
  struct Current {
    Handle display = nullptr, draw = nullptr, read = nullptr, context = nullptr;
  };

  Egl egl_;
  Handle display_ = nullptr;
  Handle context_ = nullptr;
  Current before_;
};

}  // namespace

std::unique_ptr<GlContext> create_egl_context(bool on_cpu) { return std::make_unique<EglContext>(on_cpu); }

}  // namespace holdfast
