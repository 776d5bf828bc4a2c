#include "render/gl_context.hpp"

#include "render/renderer_error.hpp"

namespace holdfast {

std::unique_ptr<GlContext> create_gl_context(RendererChoice choice) {
  const auto made = [](auto create, std::string reason) {
    std::unique_ptr<GlContext> context = create();
    context->set_reason(std::move(reason));
    return context;
  };
  const bool any = choice == RendererChoice::automatic;
  std::string osmesa_fails;
  if (choice != RendererChoice::egl) {
    try {
      return made(create_osmesa_context, any ? "the first choice" : "asked for");
    } catch (const Error& error) {
      osmesa_fails = error.what();
    }
    if (!any) fail_rendering(ErrorCode::renderer, "no OSMesa (" + osmesa_fails + "); install the package libosmesa6");
  }
  try {
    return made([any] { return create_egl_context(any); },
                any ? "there is no OSMesa (" + osmesa_fails + ")" : "asked for");
  } catch (const Error& error) {
    const std::string egl_fails = error.what();
    if (!any) {
      fail_rendering(ErrorCode::renderer,
                     "no EGL (" + egl_fails + "); install the packages libegl1 and libgl1-mesa-dri");
    }
    fail_rendering(ErrorCode::renderer, "neither OSMesa (" + osmesa_fails + ") nor EGL (" + egl_fails +
                                            "); install the package libosmesa6, or libegl1 and libgl1-mesa-dri");
  }
}

}  // namespace holdfast
