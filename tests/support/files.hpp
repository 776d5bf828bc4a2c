#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast::test {

/// A fresh folder below the system's temporary one, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  /// Writes a file of the folder and returns its path.
  std::filesystem::path write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

std::string read_file(const std::filesystem::path& path);

/// As glTF holds bytes in its text.
std::string base64(const std::string& bytes);

struct CaughtError {
  bool thrown = false;
  ErrorCode code{};
  std::string message;

  /// One line, of this code, with all of these words.
  bool says(ErrorCode wanted, std::initializer_list<const char*> words) const;
};

/// Runs `action` and keeps the holdfast::Error it throws; other exceptions pass through.
CaughtError error_of(const std::function<void()>& action);

}  // namespace holdfast::test
