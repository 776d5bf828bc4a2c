#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <string>
#include <system_error>
#include <utility>

#include "holdfast/device.hpp"

namespace holdfast {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kRoom = std::uintmax_t{16} << 20;  // bytes, of all of Holdfast's kernels and what they leave

/// Folder that the first of these variables that is set names, or one below it; empty where none is set.
fs::path first_of(std::initializer_list<std::pair<const char*, const char*>> places) {
  for (const auto& [variable, below] : places) {
    const char* value = std::getenv(variable);
    if (value != nullptr && *value != '\0') return *below != '\0' ? fs::path(value) / below : fs::path(value);
  }
  return {};
}

bool can_be_written(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (!fs::is_directory(folder, failed)) return false;
  const fs::path probe = folder / (".holdfast" + std::to_string(::getpid()));
  bool written = false;
  {
    std::ofstream file(probe, std::ios::binary);
    file << std::string(4096, ' ');
    file.flush();
    written = file.good();
  }
  fs::remove(probe, failed);
  const fs::space_info space = fs::space(folder, failed);
  return written && (failed || space.available >= kRoom);
}

}  // namespace

fs::path default_cache_folder() {
  return first_of({{"HOLDFAST_CACHE_DIR", ""}, {"XDG_CACHE_HOME", "holdfast"}, {"HOME", ".cache/holdfast"}});
}

std::optional<fs::path> unwritable_pocl_cache() {
  // As PoCL looks for it.
  fs::path folder =
      first_of({{"POCL_CACHE_DIR", ""}, {"XDG_CACHE_HOME", "pocl/kcache"}, {"HOME", ".cache/pocl/kcache"}});
  if (folder.empty()) folder = "/tmp/pocl/kcache";
  return can_be_written(folder) ? std::nullopt : std::optional(folder);
}

}  // namespace holdfast
