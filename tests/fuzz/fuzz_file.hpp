#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "holdfast/error.hpp"

namespace holdfast::fuzz {

/// Writes the fuzzer's input to a file of this process, of the name that the target is built with, and reads it: an
/// Error is an answer, everything else that is thrown is a defect.
template <typename Read>
int read_as_file(const std::uint8_t* data, std::size_t size, const Read& read) {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path made =
        std::filesystem::temp_directory_path() / ("holdfast-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    return made;
  }();
  const std::filesystem::path path = folder / FUZZ_NAME;
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    read(path);
  } catch (const Error&) {
    // Refused, in a line.
  }
  return 0;
}

}  // namespace holdfast::fuzz
