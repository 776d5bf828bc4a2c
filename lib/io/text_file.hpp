#pragma once

#include <filesystem>
#include <string>

namespace holdfast::io {

/// Whole contents of a text file; throws Error(file) when it is missing, a folder, or cannot be read. `what` names its
/// role in the message ("camera file").
std::string read_text_file(const std::filesystem::path& path, const std::string& what);

/// Throws Error(file) when there is no regular file at `path`; `what` as above.
void require_file(const std::filesystem::path& path, const std::string& what);

/// Writes a file whole or not at all: a neighbour is written first and then renamed. Throws Error(output).
void write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace holdfast::io
