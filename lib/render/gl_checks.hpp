#pragma once

#include <string>

#include "render/gl_context.hpp"
#include "render/gl_framebuffers.hpp"
#include "render/gl_functions.hpp"
#include "render/gl_programs.hpp"

namespace holdfast {

/// Name, GL_RENDERER, GL_VERSION of the context, which is current. Throws Error(renderer) when calls do not reach it.
std::string describe(const GlContext& context);

/// Throws Error(renderer) when a call has failed since errors were last looked for. `description`: describe()'s.
void check_errors(const GlFunctions& gl, const std::string& description, const char* action);

/// OpenGL calls that end in the wrong library do nothing and report nothing: draws a triangle over the upper left half
/// and looks whether it is there. Throws Error(renderer) when it is not.
void check_drawing(const GlFunctions& gl, const std::string& description, GlFramebuffers& framebuffers,
                   const GlPrograms& programs);

}  // namespace holdfast
