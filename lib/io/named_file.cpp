#include "io/named_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "holdfast/error.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;

namespace {

int hexadecimal_digit(char digit) {
  const char* digits = "0123456789abcdef";
  const char* found = digit == 0 ? nullptr : std::strchr(digits, std::tolower(static_cast<unsigned char>(digit)));
  return found == nullptr ? -1 : static_cast<int>(found - digits);
}

std::string percent_decoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size() && hexadecimal_digit(text[i + 1]) >= 0 &&
                        hexadecimal_digit(text[i + 2]) >= 0;
    if (escape) {
      decoded += static_cast<char>(hexadecimal_digit(text[i + 1]) * 16 + hexadecimal_digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

}  // namespace

std::optional<fs::path> named_file(const std::string& name, const std::vector<fs::path>& folders) {
  std::string plain(trimmed(name));
  std::replace(plain.begin(), plain.end(), '\\', '/');
  if (plain.empty()) {
    return std::nullopt;
  }
  for (const fs::path& file :
       {fs::path(name), fs::path(plain), fs::path(percent_decoded(plain)), fs::path(plain).filename()}) {
    for (const fs::path& folder : folders) {
      std::error_code ignored;
      if (fs::is_regular_file(folder / file, ignored)) {
        return folder / file;
      }
    }
  }
  return std::nullopt;
}

fs::path find_texture(const fs::path& model, const std::string& name, std::vector<fs::path> folders) {
  folders.push_back(model.parent_path());
  if (const auto found = named_file(name, folders)) {
    return *found;
  }
  std::string plain(trimmed(name));
  std::replace(plain.begin(), plain.end(), '\\', '/');
  throw Error(ErrorCode::file,
              fmt::format("texture '{}' of model '{}' does not exist: put it there or correct the name in the model",
                          (folders.front() / plain).string(), model.string()));
}

}  // namespace holdfast::io
