#include "device/program_cache.hpp"

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <system_error>
#include <thread>
#include <vector>

#include "base/digest.hpp"
#include "holdfast/device.hpp"
#include "holdfast/error.hpp"

namespace holdfast {
namespace {

std::string digest(const void* data, std::size_t size) {
  Digest digest;
  digest.add(data, size);
  return digest.text();
}

/// A binary's length and hash precede it in its file: drivers are not to be trusted with a damaged one (PoCL aborts).
std::string seal(const std::vector<unsigned char>& binary) {
  return "holdfast " + std::to_string(binary.size()) + ' ' + digest(binary.data(), binary.size()) + '\n';
}

/// The binary in the file; empty when there is none or it is not as it was written.
std::vector<unsigned char> read_binary(const std::filesystem::path& path) {
  std::error_code failed;
  const std::uintmax_t size =
      std::filesystem::is_regular_file(path, failed) ? std::filesystem::file_size(path, failed) : 0;
  std::ifstream file(path, std::ios::binary);
  std::string first_line;
  if (failed || !std::getline(file, first_line) || size <= first_line.size()) return {};
  std::vector<unsigned char> binary(static_cast<std::size_t>(size) - first_line.size() - 1);
  file.read(reinterpret_cast<char*>(binary.data()), static_cast<std::streamsize>(binary.size()));
  return file && first_line + '\n' == seal(binary) ? binary : std::vector<unsigned char>{};
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

ProgramCache::ProgramCache(const std::filesystem::path& folder)
    : folder_(folder.empty() ? default_cache_folder() : folder) {}

cl::Program ProgramCache::build(const cl::Context& context, const cl::Device& device, const std::string& source,
                                const std::string& options) const {
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  const std::string key = source + '\n' + options + '\n' + platform.getInfo<CL_PLATFORM_NAME>() + '\n' +
                          platform.getInfo<CL_PLATFORM_VERSION>() + '\n' + device.getInfo<CL_DEVICE_NAME>() + '\n' +
                          device.getInfo<CL_DEVICE_VERSION>() + '\n' + device.getInfo<CL_DRIVER_VERSION>();
  const std::filesystem::path file = folder_.empty() ? folder_ : folder_ / (digest(key.data(), key.size()) + ".clbin");
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
    const auto unwritable = unwritable_pocl_cache();
    if (unwritable && platform.getInfo<CL_PLATFORM_NAME>().find("Portable") != std::string::npos) {
      throw Error(ErrorCode::device, "PoCL cannot compile the OpenCL kernels, since it cannot write to its cache, '" +
                                         unwritable->string() +
                                         "': make room there, or set POCL_CACHE_DIR to a folder " +
                                         "that can be written");
    }
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
