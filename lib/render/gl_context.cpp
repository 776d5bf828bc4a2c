#include "render/gl_context.hpp"

#include <dlfcn.h>

#include <array>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast {
namespace {

// What Holdfast uses of OSMesa's interface, declared here: its header would declare every gl function too.
struct OsMesaContextTag;
using OsMesaHandle = OsMesaContextTag*;
using VoidFunction = void (*)();
using CreateContextAttribs = OsMesaHandle (*)(const int* attributes, OsMesaHandle share);
using DestroyContext = void (*)(OsMesaHandle context);
using MakeCurrent = GLboolean (*)(OsMesaHandle context, void* buffer, GLenum type, GLsizei width, GLsizei height);
using GetProcAddress = VoidFunction (*)(const char* name);

constexpr int kFormat = 0x22;
constexpr int kDepthBits = 0x30;
constexpr int kStencilBits = 0x31;
constexpr int kAccumulationBits = 0x32;
constexpr int kProfile = 0x33;
constexpr int kCoreProfile = 0x34;
constexpr int kMajorVersion = 0x36;
constexpr int kMinorVersion = 0x37;

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorCode::renderer, "renderer: " + message); }

void* load_osmesa() {
  std::string reason;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
    // Local, because OSMesa and libGL export the same names. Never unloaded: the driver's threads outlive contexts.
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
      return library;
    }
    if (reason.empty()) {
      const char* text = dlerror();
      reason = text != nullptr ? text : "unknown reason";
    }
  }
  fail("cannot load OSMesa (" + reason + "); install the package libosmesa6");
}

template <typename Function>
Function symbol(void* library, const char* name) {
  void* address = dlsym(library, name);
  if (address == nullptr) {
    fail(std::string("the installed OSMesa has no ") + name + "; install libosmesa6 of Mesa 12 or later");
  }
  return reinterpret_cast<Function>(address);
}

class OsMesaContext final : public GlContext {
 public:
  OsMesaContext() {
    void* library = load_osmesa();
    const auto create = symbol<CreateContextAttribs>(library, "OSMesaCreateContextAttribs");
    const auto get_address = symbol<GetProcAddress>(library, "OSMesaGetProcAddress");
    destroy_ = symbol<DestroyContext>(library, "OSMesaDestroyContext");
    make_current_ = symbol<MakeCurrent>(library, "OSMesaMakeCurrent");

    // No depth, stencil or accumulation buffer: drawing goes to framebuffer objects, never to the default buffer.
    constexpr std::array<int, 16> attributes = {kFormat,
                                                GL_RGBA,
                                                kDepthBits,
                                                0,
                                                kStencilBits,
                                                0,
                                                kAccumulationBits,
                                                0,
                                                kProfile,
                                                kCoreProfile,
                                                kMajorVersion,
                                                3,
                                                kMinorVersion,
                                                3,
                                                0,
                                                0};
    context_ = create(attributes.data(), nullptr);
    if (context_ == nullptr) {
      fail("OSMesa cannot create an OpenGL 3.3 core context; install libosmesa6 with the llvmpipe driver");
    }
    if (const char* missing = gl_.load(get_address)) {
      destroy_(context_);
      fail(std::string("the installed OSMesa has no ") + missing + "; install libosmesa6 of Mesa 12 or later");
    }
  }

  ~OsMesaContext() override { destroy_(context_); }

  void make_current() override {
    if (make_current_(context_, default_buffer_.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_FALSE) {
      fail("OSMesa cannot make its context current in this thread; reinstall the package libosmesa6");
    }
  }

  void release() noexcept override { make_current_(nullptr, nullptr, 0, 0, 0); }

 private:
  DestroyContext destroy_ = nullptr;
  MakeCurrent make_current_ = nullptr;
  OsMesaHandle context_ = nullptr;
  std::array<GLubyte, 4> default_buffer_{};  // OSMesa insists on one
};

}  // namespace

std::unique_ptr<GlContext> create_gl_context() { return std::make_unique<OsMesaContext>(); }

}  // namespace holdfast
