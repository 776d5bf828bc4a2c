#pragma once

namespace holdfast {

/// Which library's OpenGL draws the model, loaded at run time. Software draws the same bits by either.
enum class RendererChoice {
  automatic,  ///< OSMesa, else EGL
  osmesa,     ///< OSMesa: on the CPU
  egl,        ///< EGL without a screen: on the CPU where Mesa is installed, else on a graphics processor
};

}  // namespace holdfast
