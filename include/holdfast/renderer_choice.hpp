#pragma once

namespace holdfast {

/// Which library's OpenGL draws the model, loaded at run time. Software draws the same bits by either.
enum class RendererChoice {
  automatic,  ///< OSMesa, else EGL, on the CPU where it can
  osmesa,     ///< OSMesa: on the CPU
  egl,        ///< EGL without a screen: on a graphics processor where there is one, else on the CPU
};

}  // namespace holdfast
