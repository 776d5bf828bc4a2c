#include "evaluation/input_checks.hpp"

#include <fmt/core.h>

#include <istream>
#include <string_view>

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

void skip_byte_order_mark(std::istream& file) {
  char mark[3] = {};
  file.read(mark, sizeof(mark));
  if (std::string_view(mark, static_cast<std::size_t>(file.gcount())) != "\xef\xbb\xbf") {
    file.clear();
    file.seekg(0);
  }
}

}  // namespace holdfast::evaluation
