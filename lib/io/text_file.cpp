#include "io/text_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

#include "holdfast/error.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;

void require_file(const fs::path& path, const std::string& what) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (path.empty()) {
    throw Error(ErrorCode::file, fmt::format("the {} has an empty name: give its path", what));
  }
  if (!fs::exists(status)) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' does not exist: check the path", what, path.string()));
  }
  if (fs::is_directory(status)) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' is a folder: give a file", what, path.string()));
  }
}

std::string read_text_file(const fs::path& path, const std::string& what) {
  require_file(path, what);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file && file.peek() != std::ifstream::traits_type::eof()) {
    text << file.rdbuf();
  }
  if (!file.is_open() || file.bad() || text.fail()) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' cannot be read ({}): check its permissions", what, path.string(),
                                             errno ? std::strerror(errno) : "unknown reason"));
  }
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";  // Windows' editors begin UTF-8 with it
  std::string content = text.str();
  if (content.starts_with(byte_order_mark)) {
    content.erase(0, byte_order_mark.size());
  }
  return content;
}

void write_text_file(const fs::path& path, const std::string& text) {
  std::error_code error;
  const bool replaceable = !fs::exists(path, error) || fs::is_regular_file(path, error);  // not so: /dev/stdout
  fs::path written = path;
  if (replaceable) {
    written += ".part";
  }
  errno = 0;
  std::ofstream file(written, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  error.clear();
  if (file && replaceable) {
    fs::rename(written, path, error);
  }
  if (!file || error) {
    const std::string reason = error ? error.message() : errno != 0 ? std::strerror(errno) : "unknown reason";
    if (replaceable) {
      fs::remove(written, error);
    }
    throw Error(ErrorCode::output,
                fmt::format("'{}' cannot be written ({}): check that its folder exists and is writable", path.string(),
                            reason));
  }
}

}  // namespace holdfast::io
