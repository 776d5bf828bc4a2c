#pragma once

#include <memory>

#include "render/gl_functions.hpp"

namespace holdfast {

/// An OpenGL 3.3 core context without a window. What is behind it (OSMesa today) stays in its source file.
class GlContext {
 public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext() = default;

  /// Makes it the calling thread's context; it must not be current in another thread. Throws Error(renderer).
  virtual void make_current() = 0;
  /// Leaves the calling thread without a context, so that another thread may take this one.
  virtual void release() noexcept = 0;

  const GlFunctions& gl() const { return gl_; }

 protected:
  GlFunctions gl_;
};

/// A context of its own, sharing nothing with others. Throws Error(renderer) when OSMesa is not installed or fails.
std::unique_ptr<GlContext> create_gl_context();

/// Keeps a context current for the length of a scope. Taking it anew in each scope is what lets several contexts live
/// in one process and one context be used from several threads in turn.
class CurrentGlContext {
 public:
  explicit CurrentGlContext(GlContext& context) : context_(context) { context_.make_current(); }
  ~CurrentGlContext() { context_.release(); }
  CurrentGlContext(const CurrentGlContext&) = delete;
  CurrentGlContext& operator=(const CurrentGlContext&) = delete;

 private:
  GlContext& context_;
};

}  // namespace holdfast
