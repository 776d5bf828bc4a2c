#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace holdfast::io {

/// Advice on a file that is whole, but not as its format wants it.
inline constexpr const char* kExportAnew = "export it anew";

/// Advice on a word that is no number.
std::string advice_on_number(std::string_view word);

/// Throws Error(file): the model cannot be read, for this reason, and what to do.
[[noreturn]] void fail_model(const std::filesystem::path& path, const std::string& reason,
                             const std::string& advice = "is the file complete?");

}  // namespace holdfast::io
