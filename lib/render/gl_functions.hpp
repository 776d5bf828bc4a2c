#pragma once

// Types and constants only: without prototypes a direct gl call cannot compile, so no call can end in a libGL that some
// other library has loaded.
#ifdef GL_GLEXT_PROTOTYPES
#error "OpenGL must be called through GlFunctions only"
#endif
#include <GL/glcorearb.h>

namespace holdfast {

// X(member, type, OpenGL name)
#define HOLDFAST_GL_FUNCTIONS(X)                                                               \
  X(attach_shader, PFNGLATTACHSHADERPROC, "glAttachShader")                                    \
  X(bind_buffer, PFNGLBINDBUFFERPROC, "glBindBuffer")                                          \
  X(bind_framebuffer, PFNGLBINDFRAMEBUFFERPROC, "glBindFramebuffer")                           \
  X(bind_renderbuffer, PFNGLBINDRENDERBUFFERPROC, "glBindRenderbuffer")                        \
  X(bind_texture, PFNGLBINDTEXTUREPROC, "glBindTexture")                                       \
  X(bind_vertex_array, PFNGLBINDVERTEXARRAYPROC, "glBindVertexArray")                          \
  X(buffer_data, PFNGLBUFFERDATAPROC, "glBufferData")                                          \
  X(check_framebuffer_status, PFNGLCHECKFRAMEBUFFERSTATUSPROC, "glCheckFramebufferStatus")     \
  X(clear, PFNGLCLEARPROC, "glClear")                                                          \
  X(compile_shader, PFNGLCOMPILESHADERPROC, "glCompileShader")                                 \
  X(create_program, PFNGLCREATEPROGRAMPROC, "glCreateProgram")                                 \
  X(create_shader, PFNGLCREATESHADERPROC, "glCreateShader")                                    \
  X(delete_shader, PFNGLDELETESHADERPROC, "glDeleteShader")                                    \
  X(delete_textures, PFNGLDELETETEXTURESPROC, "glDeleteTextures")                              \
  X(color_mask, PFNGLCOLORMASKPROC, "glColorMask")                                             \
  X(disable, PFNGLDISABLEPROC, "glDisable")                                                    \
  X(draw_elements, PFNGLDRAWELEMENTSPROC, "glDrawElements")                                    \
  X(front_face, PFNGLFRONTFACEPROC, "glFrontFace")                                             \
  X(enable, PFNGLENABLEPROC, "glEnable")                                                       \
  X(enable_vertex_attrib_array, PFNGLENABLEVERTEXATTRIBARRAYPROC, "glEnableVertexAttribArray") \
  X(framebuffer_renderbuffer, PFNGLFRAMEBUFFERRENDERBUFFERPROC, "glFramebufferRenderbuffer")   \
  X(gen_buffers, PFNGLGENBUFFERSPROC, "glGenBuffers")                                          \
  X(gen_framebuffers, PFNGLGENFRAMEBUFFERSPROC, "glGenFramebuffers")                           \
  X(gen_renderbuffers, PFNGLGENRENDERBUFFERSPROC, "glGenRenderbuffers")                        \
  X(gen_textures, PFNGLGENTEXTURESPROC, "glGenTextures")                                       \
  X(gen_vertex_arrays, PFNGLGENVERTEXARRAYSPROC, "glGenVertexArrays")                          \
  X(get_error, PFNGLGETERRORPROC, "glGetError")                                                \
  X(get_integer, PFNGLGETINTEGERVPROC, "glGetIntegerv")                                        \
  X(get_program, PFNGLGETPROGRAMIVPROC, "glGetProgramiv")                                      \
  X(get_program_info_log, PFNGLGETPROGRAMINFOLOGPROC, "glGetProgramInfoLog")                   \
  X(get_shader, PFNGLGETSHADERIVPROC, "glGetShaderiv")                                         \
  X(get_shader_info_log, PFNGLGETSHADERINFOLOGPROC, "glGetShaderInfoLog")                      \
  X(get_string, PFNGLGETSTRINGPROC, "glGetString")                                             \
  X(get_uniform_location, PFNGLGETUNIFORMLOCATIONPROC, "glGetUniformLocation")                 \
  X(link_program, PFNGLLINKPROGRAMPROC, "glLinkProgram")                                       \
  X(pixel_store, PFNGLPIXELSTOREIPROC, "glPixelStorei")                                        \
  X(read_pixels, PFNGLREADPIXELSPROC, "glReadPixels")                                          \
  X(renderbuffer_storage, PFNGLRENDERBUFFERSTORAGEPROC, "glRenderbufferStorage")               \
  X(shader_source, PFNGLSHADERSOURCEPROC, "glShaderSource")                                    \
  X(texture_image_2d, PFNGLTEXIMAGE2DPROC, "glTexImage2D")                                     \
  X(texture_parameter, PFNGLTEXPARAMETERIPROC, "glTexParameteri")                              \
  X(uniform3, PFNGLUNIFORM3FVPROC, "glUniform3fv")                                             \
  X(uniform_matrix4, PFNGLUNIFORMMATRIX4FVPROC, "glUniformMatrix4fv")                          \
  X(use_program, PFNGLUSEPROGRAMPROC, "glUseProgram")                                          \
  X(vertex_attrib_pointer, PFNGLVERTEXATTRIBPOINTERPROC, "glVertexAttribPointer")              \
  X(viewport, PFNGLVIEWPORTPROC, "glViewport")

/// The OpenGL functions of one context's library.
struct GlFunctions {
#define HOLDFAST_GL_MEMBER(member, type, name) type member = nullptr;
  HOLDFAST_GL_FUNCTIONS(HOLDFAST_GL_MEMBER)
#undef HOLDFAST_GL_MEMBER

  /// Fills the table from `get_address(name)`, which returns a pointer to void function or null. Returns the first
  /// name that is missing, or null when all are there.
  template <typename GetAddress>
  const char* load(GetAddress get_address) {
#define HOLDFAST_GL_LOAD(member, type, name)          \
  member = reinterpret_cast<type>(get_address(name)); \
  if (member == nullptr) {                            \
    return name;                                      \
  }
    HOLDFAST_GL_FUNCTIONS(HOLDFAST_GL_LOAD)
#undef HOLDFAST_GL_LOAD
    return nullptr;
  }
};

}  // namespace holdfast
