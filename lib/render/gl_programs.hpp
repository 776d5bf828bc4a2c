#pragma once

#include <array>
#include <cstddef>

#include "render/gl_functions.hpp"

namespace holdfast {

/// Where a surface's colour comes from; each has its own variant of the shaders.
enum class Appearance { textured, vertex_colored, unknown };

/// A variant of the shaders and the places of its uniforms; -1: it has none of that name.
struct Program {
  GLuint name = 0;
  GLint clip_from_object = -1;
  GLint camera_from_object = -1;
  GLint shading = -1;
};

/// The shaders that surface is drawn with.
class GlPrograms {
 public:
  /// `texture_samples`: RendererOptions'. Throws Error(renderer) with the compiler's log when one does not compile.
  GlPrograms(const GlFunctions& gl, int texture_samples);

  /// `shaded`: light falls on the surface.
  const Program& of(Appearance appearance, bool shaded = false) const {
    return (shaded ? shaded_ : plain_)[static_cast<std::size_t>(appearance)];
  }

 private:
  std::array<Program, 3> plain_, shaded_;  ///< one an appearance
};

}  // namespace holdfast
