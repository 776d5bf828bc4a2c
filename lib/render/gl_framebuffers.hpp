#pragma once

#include <vector>

#include "holdfast/renderer.hpp"
#include "render/gl_functions.hpp"

namespace holdfast {

/// What is drawn into: colour and float depth, made when first needed. Few sizes, so that a small region clears and
/// reads little and still all buffers exist after a few frames.
class GlFramebuffers {
 public:
  static constexpr int kSmallest = 64;  ///< sides of the smallest, pixels

  /// For regions up to this size. Throws Error(invalid_argument) when OpenGL does not take it.
  GlFramebuffers(const GlFunctions& gl, int max_width, int max_height);

  int max_width() const { return widths_.back(); }
  int max_height() const { return heights_.back(); }

  /// Regions of this size are drawn and read from now on. Throws Error(renderer).
  void bind(int width, int height);
  /// What was drawn, a row `stride` pixels after the one before.
  void read(int width, int height, int stride, const RenderTarget& target) const;

 private:
  const GlFunctions& gl_;
  std::vector<int> widths_, heights_;  ///< size classes
  std::vector<GLuint> framebuffers_;   ///< one a pair of size classes, widths first; 0: not made yet
};

}  // namespace holdfast
