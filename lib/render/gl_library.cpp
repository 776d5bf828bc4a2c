#include "render/gl_library.hpp"

#include "holdfast/error.hpp"

namespace holdfast {

void fail_context(const std::string& message) { throw Error(ErrorCode::renderer, message); }

void* open_gl_library(std::initializer_list<const char*> names) {
  std::string reason;
  for (const char* name : names) {
    // Local, because OSMesa and libGL export the same names.
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) return library;
    if (!reason.empty()) continue;
    const char* text = dlerror();
    reason = text != nullptr ? text : "cannot be loaded";
  }
  fail_context(reason);
}

}  // namespace holdfast
