#include "render/gl_checks.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/gl_geometry.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {

std::string describe(const GlContext& context) {
  const GlFunctions& gl = context.gl();
  const auto* renderer = reinterpret_cast<const char*>(gl.get_string(GL_RENDERER));
  const auto* version = reinterpret_cast<const char*>(gl.get_string(GL_VERSION));
  if (renderer == nullptr || version == nullptr) {
    fail_rendering(ErrorCode::renderer,
                   std::string("OpenGL calls do not reach ") + context.name() + " (no GL_RENDERER); reinstall it");
  }
  return std::string(context.name()) + ": " + renderer + ", OpenGL " + version;
}

void check_errors(const GlFunctions& gl, const std::string& description, const char* action) {
  const GLenum code = gl.get_error();
  if (code != GL_NO_ERROR) {
    fail_rendering(ErrorCode::renderer, std::string("OpenGL error ") + std::to_string(code) + " while " + action +
                                            (code == GL_OUT_OF_MEMORY ? " (out of memory)" : "") +
                                            "; renderer: " + description);
  }
}

void check_drawing(const GlFunctions& gl, const std::string& description, GlFramebuffers& framebuffers,
                   const GlPrograms& programs) {
  constexpr int kSize = GlFramebuffers::kSmallest;
  const std::array<std::uint8_t, 4> color = {255, 128, 0, 255};
  framebuffers.bind(kSize, kSize);
  gl.viewport(0, 0, kSize, kSize);
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const Batch batch{0, 3, 0};
  upload_geometry(gl,
                  {{{{-1, -1, 0}, {}, color}, {{1, -1, 0}, {}, color}, {{-1, 1, 0}, {}, color}}, {0, 1, 2}, {batch}});
  const Program& program = programs.of(Appearance::vertex_colored);
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  gl.use_program(program.name);
  gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, identity.data());
  draw_triangles(gl, batch);

  constexpr std::size_t kPixels = kSize * kSize;
  std::vector<std::uint8_t> rgba(kPixels * 4, 99);
  std::vector<float> depth(kPixels, -1.0F);
  framebuffers.read(kSize, kSize, kSize, {rgba.data(), depth.data(), kSize});
  const bool drawn = std::equal(color.begin(), color.end(), rgba.begin()) && depth.front() == 0.5F;
  const bool empty = rgba.back() == 0 && depth.back() == 1.0F;
  if (!drawn || !empty) {
    fail_rendering(ErrorCode::renderer,
                   "OpenGL does not draw (a test triangle did not come out; renderer: " + description +
                       "); another OpenGL library may be in its way, or try the other renderer (osmesa, egl)");
  }
}

}  // namespace holdfast
