#pragma once

#include <memory>
#include <string>
#include <utility>

#include "holdfast/renderer_choice.hpp"
#include "render/gl_functions.hpp"

namespace holdfast {

/// An OpenGL 3.3 core context without a window. Where it comes from stays in its source file.
class GlContext {
 public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext() = default;

  /// Makes it the calling thread's context; it must not be current in another thread. Throws Error(renderer).
  virtual void make_current() = 0;
  /// Leaves the calling thread without this context, so that another thread may take it.
  virtual void release() noexcept = 0;

  /// "OSMesa", "EGL".
  virtual const char* name() const = 0;

  const GlFunctions& gl() const { return gl_; }
  /// Why it is this one.
  const std::string& reason() const { return reason_; }
  void set_reason(std::string reason) { reason_ = std::move(reason); }

 protected:
  GlFunctions gl_;

 private:
  std::string reason_;
};

/// A context of its own, sharing nothing with others. Throws Error(renderer) when what is asked for, or all there is,
/// is not installed or fails.
std::unique_ptr<GlContext> create_gl_context(RendererChoice choice);

/// One way each to such a context: throw Error(renderer) with the reason alone.
std::unique_ptr<GlContext> create_osmesa_context();
/// `on_cpu`: rather than on a graphics processor, where there are both.
std::unique_ptr<GlContext> create_egl_context(bool on_cpu);

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
