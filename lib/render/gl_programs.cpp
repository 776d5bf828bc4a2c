#include "render/gl_programs.hpp"

#include <string>

#include "device/embedded_text.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {
namespace {

GLuint compile(const GlFunctions& gl, GLenum kind, const char* file, const std::string& variant) {
  const std::string text =
      std::string("#version 330 core\n#define ") + variant + "\n" + std::string(embedded_text(file));
  const GLuint shader = gl.create_shader(kind);
  const char* source = text.c_str();
  gl.shader_source(shader, 1, &source, nullptr);
  gl.compile_shader(shader);
  GLint compiled = GL_FALSE;
  gl.get_shader(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE) {
    std::array<char, 512> log{};
    gl.get_shader_info_log(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail_rendering(ErrorCode::renderer, std::string("OpenGL does not compile ") + file + " (" + variant +
                                            "): " + log.data() + "; install libosmesa6, or a newer driver");
  }
  return shader;
}

Program link(const GlFunctions& gl, const std::string& variant) {
  const GLuint vertex_shader = compile(gl, GL_VERTEX_SHADER, "model.vert", variant);
  const GLuint fragment_shader = compile(gl, GL_FRAGMENT_SHADER, "model.frag", variant);
  Program program;
  program.name = gl.create_program();
  gl.attach_shader(program.name, vertex_shader);
  gl.attach_shader(program.name, fragment_shader);
  gl.link_program(program.name);
  gl.delete_shader(vertex_shader);
  gl.delete_shader(fragment_shader);
  GLint linked = GL_FALSE;
  gl.get_program(program.name, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::array<char, 512> log{};
    gl.get_program_info_log(program.name, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail_rendering(ErrorCode::renderer, std::string("OpenGL does not link the shaders (") + variant +
                                            "): " + log.data() + "; install libosmesa6, or a newer driver");
  }
  program.clip_from_object = gl.get_uniform_location(program.name, "clip_from_object");
  program.camera_from_object = gl.get_uniform_location(program.name, "camera_from_object");
  program.shading = gl.get_uniform_location(program.name, "shading");
  return program;
}

}  // namespace

GlPrograms::GlPrograms(const GlFunctions& gl, int texture_samples) {
  const std::string textured = texture_samples == 1 ? "TEXTURED" : "TEXTURED\n#define SUPERSAMPLED";
  const auto link_all = [&](const std::string& light) -> std::array<Program, 3> {
    return {link(gl, textured + light), link(gl, "VERTEX_COLORED" + light), link(gl, "UNKNOWN" + light)};
  };
  plain_ = link_all("");
  shaded_ = link_all("\n#define SHADED");
}

}  // namespace holdfast
