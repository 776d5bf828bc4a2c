#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

namespace holdfast::app {

/// A file being written; every failure (no permission, disk full) is an Error(output) that names it.
class OutputFile {
 public:
  /// Creates or empties the file.
  explicit OutputFile(const std::filesystem::path& path);

  /// Writes at once, so that what was written survives whatever happens next. What does not fit as a whole is taken
  /// back, where the file can be rewound.
  void write(std::string_view text);

  /// False for pipes and terminals.
  bool can_rewind() const { return can_rewind_; }
  /// Goes back: what is written next stands at byte `offset`, and takes all that follows with it if it does not fit.
  void rewind_to(long offset);

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
  bool can_rewind_ = false;
};

/// Writes a file whole or not at all: beside it first, in its place when it is complete. Throws Error(output).
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// The name under which a file is written before it takes its own: video.part.mp4 for video.mp4.
std::filesystem::path part_of(const std::filesystem::path& path);

/// Puts a complete part in its file's place. Throws Error(output).
void put_in_place(const std::filesystem::path& path);

/// Throws Error(output) when a file cannot be created or written at `path`; leaves what is there as it is.
void require_writable(const std::filesystem::path& path);

}  // namespace holdfast::app
