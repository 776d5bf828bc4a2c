#include "evaluation/input_checks.hpp"

#include <fmt/core.h>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {

void bad_file(const std::filesystem::path& path, const std::string& what) {
  throw Error(ErrorCode::file, fmt::format("{}: {}", path.string(), what));
}

Pose checked(const Pose& pose, const std::filesystem::path& path, const std::string& where) {
  try {
    validate_pose(pose);
  } catch (const Error& error) {
    throw Error(ErrorCode::pose, fmt::format("{}, {}: {}", path.string(), where, error.what()));
  }
  return renormalized(pose);
}

}  // namespace holdfast::evaluation
