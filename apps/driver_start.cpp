#include "driver_start.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "holdfast/device.hpp"
#include "messages.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

/// A folder for temporary files that is this user's alone; nothing where there is none.
std::optional<fs::path> private_folder() {
  std::error_code failed;
  const fs::path parent = fs::temp_directory_path(failed);
  if (failed) return std::nullopt;
  fs::path folder = parent / ("holdfast-pocl-" + std::to_string(geteuid()));
  mkdir(folder.c_str(), S_IRWXU);
  struct stat found {};
  const bool own = lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == geteuid() &&
                   (found.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  return own ? std::optional(folder) : std::nullopt;
}

void replace_unwritable_cache() {
  const std::optional<fs::path> unwritable = unwritable_pocl_cache();
  if (!unwritable) return;
  const std::optional<fs::path> folder = private_folder();
  if (!folder) return;
  setenv("POCL_CACHE_DIR", folder->c_str(), 1);
  if (unwritable_pocl_cache()) {
    setenv("POCL_CACHE_DIR", unwritable->c_str(), 1);  // as bad: the message names the folder that is meant
    return;
  }
  print_warning("PoCL cannot write its compiled kernels to '" + unwritable->string() + "': they go to '" +
                folder->string() + "'; set POCL_CACHE_DIR to a folder that can be written");
}

}  // namespace

void start_drivers() {
  replace_unwritable_cache();
  (void)Device::list();
}

}  // namespace holdfast::app
