#include "render/gl_framebuffers.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include "render/renderer_error.hpp"

namespace holdfast {
namespace {

std::vector<int> size_classes(int maximum) {
  std::vector<int> sizes;
  for (int size = GlFramebuffers::kSmallest; size < maximum; size *= 2) {
    sizes.push_back(size);
    if (size / 2 * 3 < maximum) sizes.push_back(size / 2 * 3);
  }
  sizes.push_back(std::max(maximum, GlFramebuffers::kSmallest));
  return sizes;
}

std::size_t class_of(const std::vector<int>& sizes, int size) {
  return static_cast<std::size_t>(std::lower_bound(sizes.begin(), sizes.end(), size) - sizes.begin());
}

}  // namespace

GlFramebuffers::GlFramebuffers(const GlFunctions& gl, int max_width, int max_height) : gl_(gl) {
  GLint max_size = 0;
  gl.get_integer(GL_MAX_RENDERBUFFER_SIZE, &max_size);
  if (max_width <= 0 || max_height <= 0 || max_width > max_size || max_height > max_size) {
    fail_rendering(ErrorCode::invalid_argument, "the largest region is given as " + size_text(max_width, max_height) +
                                                    " pixels; both sides must be in 1 to " + std::to_string(max_size));
  }
  widths_ = size_classes(max_width);
  heights_ = size_classes(max_height);
  framebuffers_.resize(widths_.size() * heights_.size());
}

void GlFramebuffers::bind(int width, int height) {
  const std::size_t column = class_of(widths_, width);
  const std::size_t row = class_of(heights_, height);
  GLuint& framebuffer = framebuffers_[row * widths_.size() + column];
  if (framebuffer != 0) {
    gl_.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
    return;
  }
  gl_.gen_framebuffers(1, &framebuffer);
  gl_.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
  const auto attach = [&](GLenum attachment, GLenum format) {
    GLuint buffer = 0;
    gl_.gen_renderbuffers(1, &buffer);
    gl_.bind_renderbuffer(GL_RENDERBUFFER, buffer);
    gl_.renderbuffer_storage(GL_RENDERBUFFER, format, widths_[column], heights_[row]);
    gl_.framebuffer_renderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  attach(GL_COLOR_ATTACHMENT0, GL_RGBA8);
  attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F);
  if (gl_.check_framebuffer_status(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    framebuffer = 0;
    fail_rendering(ErrorCode::renderer, "OpenGL cannot make a framebuffer of " +
                                            size_text(widths_[column], heights_[row]) +
                                            " pixels with float depth; install libosmesa6, or another driver");
  }
}

void GlFramebuffers::read(int width, int height, int stride, const RenderTarget& target) const {
  gl_.pixel_store(GL_PACK_ROW_LENGTH, stride);
  if (target.rgba != nullptr) {
    gl_.read_pixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, target.rgba);
  }
  if (target.depth != nullptr) {
    gl_.read_pixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, target.depth);
  }
}

}  // namespace holdfast
