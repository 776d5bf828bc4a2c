#include "program_cache.hpp"

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <system_error>
#include <thread>
#include <vector>

#include "holdfast/error.hpp"

namespace holdfast {
namespace {

std::filesystem::path default_folder() {
  const auto variable = [](const char* name) -> std::filesystem::path {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
  };
  if (const auto folder = variable("HOLDFAST_CACHE_DIR"); !folder.empty()) return folder;
  if (const auto folder = variable("XDG_CACHE_HOME"); !folder.empty()) return folder / "holdfast";
  if (const auto folder = variable("HOME"); !folder.empty()) return folder / ".cache" / "holdfast";
  return {};
}

/// FNV-1a, 64 bit.
std::uint64_t hash(const std::string& text, std::uint64_t seed) {
  std::uint64_t value = seed;
  for (const char c : text) {
    value ^= static_cast<unsigned char>(c);
    value *= 1099511628211ull;
  }
  return value;
}

/// 128 bits of hash as text.
std::string digest(const std::string& text) {
  constexpr std::uint64_t first = 14695981039346656037ull, second = 1469598103934665603ull;
  char name[40];
  std::snprintf(name, sizeof(name), "%016llx%016llx", static_cast<unsigned long long>(hash(text, first)),
                static_cast<unsigned long long>(hash(text, second)));
  return name;
}

/// A binary's length and hash precede it in its file: drivers are not to be trusted with a damaged one (PoCL aborts).
std::string seal(const std::vector<unsigned char>& binary) {
  const std::string text(binary.begin(), binary.end());
  return "holdfast " + std::to_string(text.size()) + ' ' + digest(text) + '\n';
}

/// The binary in the file; empty when there is none or it is not as it was written.
std::vector<unsigned char> read_binary(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string first_line;
  std::getline(file, first_line);
  std::vector<unsigned char> binary;
  // What cannot be read, a folder or a broken disk, throws here and nowhere else.
  try {
    binary.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  } catch (const std::exception&) {
    return {};
  }
  return first_line + '\n' == seal(binary) ? binary : std::vector<unsigned char>{};
}

void write_binary(const std::filesystem::path& path, const std::vector<unsigned char>& binary) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  // Another process may read or write the same file: it only ever sees a complete one.
  const auto temporary = path.string() + ".tmp" + std::to_string(::getpid()) + "_" +
                         std::to_string(std::hash<std::thread::id>{}(std::this_thread::get_id()));
  {
    std::ofstream file(temporary, std::ios::binary);
    file << seal(binary);
    file.write(reinterpret_cast<const char*>(binary.data()), static_cast<std::streamsize>(binary.size()));
    file.flush();
    if (!file) {
      file.close();
      std::filesystem::remove(temporary, error);
      return;
    }
  }
  std::filesystem::rename(temporary, path, error);
  if (error) std::filesystem::remove(temporary, error);
}

}  // namespace

ProgramCache::ProgramCache(const std::filesystem::path& folder) : folder_(folder.empty() ? default_folder() : folder) {}

cl::Program ProgramCache::build(const cl::Context& context, const cl::Device& device, const std::string& source,
                                const std::string& options) const {
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  const std::string key = source + '\n' + options + '\n' + platform.getInfo<CL_PLATFORM_NAME>() + '\n' +
                          platform.getInfo<CL_PLATFORM_VERSION>() + '\n' + device.getInfo<CL_DEVICE_NAME>() + '\n' +
                          device.getInfo<CL_DEVICE_VERSION>() + '\n' + device.getInfo<CL_DRIVER_VERSION>();
  const std::filesystem::path file = folder_.empty() ? folder_ : folder_ / (digest(key) + ".clbin");
  if (!file.empty()) {
    const auto binary = read_binary(file);
    if (!binary.empty()) {
      try {
        cl::Program program(context, {device}, cl::Program::Binaries{binary});
        program.build({device}, options.c_str());
        return program;
      } catch (const cl::Error&) {
        // A driver that takes its own binary no longer: compile from source and replace it.
      }
    }
  }
  cl::Program program(context, source);
  try {
    program.build({device}, options.c_str());
  } catch (const cl::Error& error) {
    throw Error(ErrorCode::device, "the OpenCL kernels do not compile on '" + device.getInfo<CL_DEVICE_NAME>() +
                                       "' (error " + std::to_string(error.err()) +
                                       "); choose another device or update its driver. Compiler log: " +
                                       program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device));
  }
  if (!file.empty()) {
    try {
      const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
      if (binaries.size() == 1 && !binaries[0].empty()) write_binary(file, binaries[0]);
    } catch (const std::exception&) {
      // No cache then.
    }
  }
  return program;
}

}  // namespace holdfast
