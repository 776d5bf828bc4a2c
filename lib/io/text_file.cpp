#include "io/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>

#include "holdfast/error.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostStreamBytes = std::size_t{256} << 20;  // of a pipe or a device, which may have no end
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";       // Windows' editors begin UTF-8 with it

/// The things that come in place of files of every kind that were not fetched the way they are to be.
void refuse_stand_in(std::string_view content, const fs::path& path, const std::string& what) {
  if (content.starts_with("version https://git-lfs.github.com/spec/")) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' is a pointer of Git LFS, not the file itself: fetch that with "
                                             "'git lfs pull'",
                                             what, path.string()));
  }
  if (content.starts_with(kByteOrderMark)) content.remove_prefix(kByteOrderMark.size());
  content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n"), content.size()));
  const std::string begin = lower(content.substr(0, 14));
  if (begin == "<!doctype html" || begin.starts_with("<html")) {
    throw Error(ErrorCode::file,
                fmt::format("{} '{}' is a web page, not the file itself: download that", what, path.string()));
  }
}

}  // namespace

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

std::string read_binary_file(const fs::path& path, const std::string& what, std::size_t most_bytes) {
  require_file(path, what);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string content;
  std::error_code unknown;
  const bool regular = fs::is_regular_file(path, unknown);
  const std::uintmax_t size = regular ? fs::file_size(path, unknown) : 0;
  if (!regular) most_bytes = std::min(most_bytes, kMostStreamBytes);
  const auto too_large = [&] {
    return Error(ErrorCode::file,
                 fmt::format("{} '{}' has more than {} bytes: is it the right file?", what, path.string(), most_bytes));
  };
  if (!unknown && size > most_bytes) throw too_large();
  // A byte more than a file has: reading it tells the end. Devices and pipes have no size.
  constexpr std::size_t usual_block = std::size_t{1} << 16;
  std::size_t block = unknown || size == 0 ? usual_block : static_cast<std::size_t>(size) + 1;
  while (file && file.peek() != std::ifstream::traits_type::eof()) {
    const std::size_t before = content.size();
    content.resize(before + block);
    file.read(content.data() + before, static_cast<std::streamsize>(block));
    content.resize(before + static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
    if (content.size() > most_bytes) throw too_large();
    block = usual_block;
  }
  if (!file.is_open() || file.bad()) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' cannot be read ({}): check its permissions", what, path.string(),
                                             errno ? std::strerror(errno) : "unknown reason"));
  }
  refuse_stand_in(content, path, what);
  return content;
}

std::string read_text_file(const fs::path& path, const std::string& what, std::size_t most_bytes) {
  std::string content = read_binary_file(path, what, most_bytes);
  if (content.starts_with("\xff\xfe") || content.starts_with("\xfe\xff")) {  // as the PowerShell's ">" writes it
    throw Error(ErrorCode::file, fmt::format("{} '{}' is text in UTF-16: save it as UTF-8", what, path.string()));
  }
  if (content.starts_with(kByteOrderMark)) {
    content.erase(0, kByteOrderMark.size());
  }
  return content;
}

std::string read_plain_text_file(const fs::path& path, const std::string& what, std::size_t most_bytes) {
  std::string content = read_text_file(path, what, most_bytes);
  if (content.find('\0') != content.npos) {
    throw Error(ErrorCode::file, fmt::format("{} '{}' is not a text file", what, path.string()));
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
