#pragma once

#include "holdfast/error.hpp"

namespace holdfast::app {

/// What the program's exit codes mean (README, `holdfast --help`).
enum ExitCode : int {
  kOk = 0,            ///< also when some frames were lost: that is a result
  kUnexpected = 1,    ///< a defect or an exhausted machine
  kUsage = 2,         ///< an option is unknown, missing or out of its range
  kInput = 3,         ///< a model, video, camera or pose is missing, unreadable or unusable
  kNoDevice = 4,      ///< no OpenCL device or no renderer
  kOutput = 5,        ///< a file cannot be written
  kLost = 6,          ///< track: held in no frame, or lost with --require-held; evaluate --within: farther off
  kInterrupted = 130  ///< Ctrl-C; files are complete up to that frame
};

constexpr int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
      return kUsage;
    case ErrorCode::model:
    case ErrorCode::camera:
    case ErrorCode::pose:
    case ErrorCode::image:
    case ErrorCode::file:
      return kInput;
    case ErrorCode::device:
    case ErrorCode::renderer:
      return kNoDevice;
    case ErrorCode::output:
      return kOutput;
  }
  return kUnexpected;
}

}  // namespace holdfast::app
