#include "io/model_fault.hpp"

#include <fmt/format.h>

#include "holdfast/error.hpp"

namespace holdfast::io {

std::string advice_on_number(std::string_view word) {
  const bool comma = word.find(',') != word.npos;
  return comma ? "write decimal points instead of commas" : "is the file complete?";
}

void fail_model(const std::filesystem::path& path, const std::string& reason, const std::string& advice) {
  throw Error(ErrorCode::file, fmt::format("model '{}' cannot be read ({}): {}", path.string(), reason, advice));
}

}  // namespace holdfast::io
