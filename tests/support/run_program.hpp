#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/files.hpp"

namespace holdfast::test {

using Arguments = std::vector<std::string>;
using Environment = std::map<std::string, std::string>;

struct ProgramRun {
  int exit_code = -1;  ///< 128 and the signal's number when a signal ended it
  std::string out;     ///< what it wrote to stdout
  std::string err;     ///< and to stderr
};

/// Runs a program with `arguments` in `folder`; `environment` is set on top of this process's own (an empty value
/// removes a variable).
ProgramRun run_program(const std::filesystem::path& program, const Arguments& arguments,
                       const std::filesystem::path& folder, const Environment& environment = {});

/// The same for the built program.
ProgramRun run_holdfast(const Arguments& arguments, const TemporaryFolder& folder, const Environment& environment = {});

/// Where the built program is.
std::string program_path();

/// That it failed with this code, and said why in one line with all of `words`.
void check_error(const ProgramRun& run, int exit_code, const std::vector<std::string>& words);

}  // namespace holdfast::test
