#include "track/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const fs::path& path, int error) {
  std::error_code failed;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string reason = error == ENOENT && !fs::exists(folder, failed)
                                 ? fmt::format("the folder '{}' does not exist", folder.string())
                                 : std::strerror(error);
  throw Error(ErrorCode::output, fmt::format("cannot write '{}': {}", path.string(), reason));
}

/// Elsewhere "-" is the standard output; here it would be a file of that name.
const fs::path& not_a_dash(const fs::path& path) {
  if (path == "-") {
    throw Error(ErrorCode::output, "cannot write '-': give /dev/stdout for the standard output");
  }
  return path;
}

}  // namespace

OutputFile::OutputFile(const fs::path& path) : path_(not_a_dash(path)), file_(std::fopen(path.c_str(), "w")) {
  if (!file_) {
    cannot_write(path_, errno);
  }
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  can_rewind_ = std::fseek(file_.get(), 0, SEEK_CUR) == 0;
}

void OutputFile::write(std::string_view text) {
  const long begin = can_rewind_ ? std::ftell(file_.get()) : -1;
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size()) {
    return;
  }
  const int error = errno;
  if (begin >= 0 && ftruncate(fileno(file_.get()), begin) == 0) {
    std::fseek(file_.get(), begin, SEEK_SET);
  }
  cannot_write(path_, error);
}

void OutputFile::rewind_to(long offset) {
  if (std::fseek(file_.get(), offset, SEEK_SET) != 0) {
    cannot_write(path_, errno);
  }
}

fs::path part_of(const fs::path& path) {
  return path.parent_path() / (path.stem().string() + ".part" + path.extension().string());
}

void put_in_place(const fs::path& path) {
  std::error_code failed;
  fs::rename(part_of(path), path, failed);
  if (failed) {
    const int error = failed.value();
    fs::remove(part_of(path), failed);
    cannot_write(path, error);
  }
}

void write_whole(const fs::path& path, std::string_view bytes) {
  std::error_code failed;
  if (fs::exists(path, failed) && !fs::is_regular_file(path, failed)) {  // /dev/stdout
    OutputFile(path).write(bytes);
    return;
  }
  try {
    OutputFile(part_of(not_a_dash(path))).write(bytes);
  } catch (const Error&) {
    const int error = errno;
    fs::remove(part_of(path), failed);
    cannot_write(path, error);
  }
  put_in_place(path);
}

void require_writable(const fs::path& path) {
  not_a_dash(path);
  std::error_code failed;
  const bool existed = fs::exists(path, failed);
  {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "a"), &std::fclose);
    if (!file) {
      cannot_write(path, errno);
    }
  }
  if (!existed) {
    fs::remove(path, failed);
  }
}

}  // namespace holdfast::app
