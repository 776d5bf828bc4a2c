#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace holdfast::io {

/// The file that another one names, looked for in these folders, in turn: as written, whatever slashes, escapes and
/// blanks at its ends the exporter wrote; then, since names may be absolute ones of the exporting machine, by its last
/// part; then whatever capitals it has, as Windows finds it.
std::optional<std::filesystem::path> named_file(const std::string& name,
                                                const std::vector<std::filesystem::path>& folders);

/// The texture that a model names, beside the model or in one of the folders. Throws Error(file) when it is missing.
std::filesystem::path find_texture(const std::filesystem::path& model, const std::string& name,
                                   std::vector<std::filesystem::path> folders = {});

}  // namespace holdfast::io
