#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>

#include "holdfast/device.hpp"

namespace holdfast {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kRoom = std::uintmax_t{16} << 20;  // bytes, of all of Holdfast's kernels and what they leave

/// As PoCL looks for it.
fs::path pocl_cache() {
  const auto variable = [](const char* name) -> fs::path {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
  };
  if (const fs::path folder = variable("POCL_CACHE_DIR"); !folder.empty()) return folder;
  if (const fs::path folder = variable("XDG_CACHE_HOME"); !folder.empty()) return folder / "pocl" / "kcache";
  if (const fs::path folder = variable("HOME"); !folder.empty()) return folder / ".cache" / "pocl" / "kcache";
  return "/tmp/pocl/kcache";
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

std::optional<fs::path> unwritable_pocl_cache() {
  const fs::path folder = pocl_cache();
  return can_be_written(folder) ? std::nullopt : std::optional(folder);
}

}  // namespace holdfast
