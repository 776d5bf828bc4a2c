#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace holdfast::io {

/// No input is larger.
inline constexpr std::size_t kMostFileBytes = std::size_t{4} << 30;

/// Whole contents of a text file, without a byte order mark; throws Error(file) when it is missing, a folder, larger
/// than `most_bytes`, or cannot be read. `what` names its role in the message ("camera file").
std::string read_text_file(const std::filesystem::path& path, const std::string& what,
                           std::size_t most_bytes = kMostFileBytes);

/// The same of a file that cannot be binary. Throws Error(file) where it is.
std::string read_plain_text_file(const std::filesystem::path& path, const std::string& what,
                                 std::size_t most_bytes = kMostFileBytes);

/// Whole contents of a file as they are. Throws Error(file) as above, and as the others do for a pointer of Git LFS or
/// a web page that stands in the file's place.
std::string read_binary_file(const std::filesystem::path& path, const std::string& what,
                             std::size_t most_bytes = kMostFileBytes);

/// Throws Error(file) when there is no regular file at `path`; `what` as above.
void require_file(const std::filesystem::path& path, const std::string& what);

/// Writes a file whole or not at all: a neighbour is written first and then renamed. Throws Error(output).
void write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace holdfast::io
