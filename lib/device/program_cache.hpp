#pragma once

#include <filesystem>
#include <string>

#include "device/opencl.hpp"

namespace holdfast {

/// Compiled programs on disk, one file each, named by a hash of all that the binary depends on. Any failure to read or
/// write only costs compiling again.
class ProgramCache {
 public:
  /// `folder` empty: default_cache_folder(); where that is empty too, nothing is kept.
  explicit ProgramCache(const std::filesystem::path& folder);

  /// The program built for this device. Throws Error(device) with the compiler's log when it does not compile.
  cl::Program build(const cl::Context& context, const cl::Device& device, const std::string& source,
                    const std::string& options) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace holdfast
