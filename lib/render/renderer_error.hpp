#pragma once

#include <string>

#include "holdfast/error.hpp"

namespace holdfast {

/// Whichever part of the renderer it was: the caller knows but one.
[[noreturn]] inline void fail_rendering(ErrorCode code, const std::string& message) {
  throw Error(code, "renderer: " + message);
}

inline std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace holdfast
