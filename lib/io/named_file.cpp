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

/// A name without blanks or quotes around it, with this system's slashes.
std::string plain_name(const std::string& name) {
  std::string_view word = trimmed(name);
  if (word.size() > 2 && word.starts_with('"') && word.ends_with('"')) word = word.substr(1, word.size() - 2);
  std::string plain(word);
  std::replace(plain.begin(), plain.end(), '\\', '/');
  return plain;
}

/// A file of this name in a folder, whatever capitals the name has; the first in the alphabet.
std::optional<fs::path> any_case(const fs::path& folder, const fs::path& name) {
  fs::path found = folder;
  std::error_code ignored;
  for (const fs::path& part : name.relative_path()) {
    if (fs::exists(found / part, ignored)) {
      found /= part;
      continue;
    }
    std::vector<fs::path> alike;
    for (fs::directory_iterator entry(found.empty() ? "." : found, ignored), end; entry != end;
         entry.increment(ignored)) {
      if (lower(entry->path().filename().string()) == lower(part.string())) alike.push_back(entry->path().filename());
    }
    if (alike.empty()) return std::nullopt;
    found /= *std::min_element(alike.begin(), alike.end());
  }
  return fs::is_regular_file(found, ignored) ? std::optional(found) : std::nullopt;
}

}  // namespace

std::optional<fs::path> named_file(const std::string& name, const std::vector<fs::path>& folders) {
  const std::string plain = plain_name(name);
  if (plain.empty()) {
    return std::nullopt;
  }
  const fs::path names[] = {name, plain, percent_decoded(plain), fs::path(plain).filename()};
  for (const fs::path& file : names) {
    for (const fs::path& folder : folders) {
      std::error_code ignored;
      if (fs::is_regular_file(folder / file, ignored)) {
        return folder / file;
      }
    }
  }
  for (const fs::path& file : names) {
    for (const fs::path& folder : folders) {
      if (const auto found = any_case(folder, file)) return found;
    }
  }
  return std::nullopt;
}

fs::path find_texture(const fs::path& model, const std::string& name, std::vector<fs::path> folders) {
  folders.push_back(model.parent_path());
  if (const auto found = named_file(name, folders)) {
    return *found;
  }
  throw Error(ErrorCode::file,
              fmt::format("texture '{}' of model '{}' does not exist: put it there or correct the name in the model",
                          (folders.front() / plain_name(name)).string(), model.string()));
}

}  // namespace holdfast::io
