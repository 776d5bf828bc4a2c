#pragma once

#include <stdexcept>
#include <string>

#include "holdfast/export.hpp"

namespace holdfast {

/// What kind of thing was wrong; programs map it to exit codes.
enum class ErrorCode {
  invalid_argument,  ///< a value passed by the caller is out of its range
  model,             ///< a mesh or its texture cannot be used
  camera,            ///< a camera's parameters cannot be used
  pose,              ///< a pose is no rigid motion, or puts the object where it cannot be seen
  image,             ///< a frame has the wrong size, format or memory
  device,            ///< no OpenCL device, or a call to it failed
  renderer,          ///< OpenGL (OSMesa, EGL) cannot be loaded or does not render
  file,              ///< an input file is missing or cannot be read
  output,            ///< a file cannot be written
};

/// The one exception of the library: misuse and failure. The message says what was wrong, where, and what to do.
/// Losing the object is a status of the tracker, never an exception.
class HOLDFAST_EXPORT Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace holdfast
