#include <array>
#include <string>

#include "render/gl_context.hpp"
#include "render/gl_library.hpp"
#include "render/renderer_error.hpp"

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

constexpr int kProfile = 0x33;
constexpr int kCoreProfile = 0x34;
constexpr int kMajorVersion = 0x36;
constexpr int kMinorVersion = 0x37;

class OsMesaContext final : public GlContext {
 public:
  OsMesaContext() {
    void* library = open_gl_library({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"});
    const auto create = required_symbol<CreateContextAttribs>(library, "OSMesaCreateContextAttribs");
    const auto get_address = required_symbol<GetProcAddress>(library, "OSMesaGetProcAddress");
    destroy_ = required_symbol<DestroyContext>(library, "OSMesaDestroyContext");
    make_current_ = required_symbol<MakeCurrent>(library, "OSMesaMakeCurrent");

    // Without a depth, stencil or accumulation buffer, as is its default: drawing goes to framebuffer objects.
    constexpr std::array<int, 8> attributes = {kProfile, kCoreProfile, kMajorVersion, 3, kMinorVersion, 3, 0, 0};
    context_ = create(attributes.data(), nullptr);
    if (context_ == nullptr) fail_context("it makes no OpenGL 3.3 core context");
    if (const char* missing = gl_.load(get_address)) {
      destroy_(context_);
      fail_context(std::string("it has no ") + missing);
    }
  }

  ~OsMesaContext() override { destroy_(context_); }

  void make_current() override {
    if (make_current_(context_, default_buffer_.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_FALSE) {
      fail_rendering(ErrorCode::renderer,
                     "OSMesa cannot make its context current in this thread; reinstall the package libosmesa6");
    }
  }

  void release() noexcept override { make_current_(nullptr, nullptr, 0, 0, 0); }

  const char* name() const override { return "OSMesa"; }

 private:
  DestroyContext destroy_ = nullptr;
  MakeCurrent make_current_ = nullptr;
  OsMesaHandle context_ = nullptr;
  std::array<GLubyte, 4> default_buffer_{};  // OSMesa insists on one
};

}  // namespace

std::unique_ptr<GlContext> create_osmesa_context() { return std::make_unique<OsMesaContext>(); }

}  // namespace holdfast
