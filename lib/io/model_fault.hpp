#pragma once

#include <filesystem>
#include <string>

namespace holdfast::io {

/// Throws Error(file): the model cannot be read, for this reason, and what to do.
[[noreturn]] void fail_model(const std::filesystem::path& path, const std::string& reason,
                             const std::string& advice = "is the file complete?");

}  // namespace holdfast::io
