#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::app {

/// What a command reads; empty names are nothing.
struct InputFiles {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> frames;            ///< videos, image folders and patterns, as given
  std::vector<std::filesystem::path> models;  ///< with all that they name
};

/// What a command writes; empty names are nothing.
struct ResultFiles {
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> folders;  ///< for files of names of their own
  std::vector<std::filesystem::path> models;   ///< OBJ, with what stands beside it
};

/// Throws Error(invalid_argument) where results would overwrite one another or what they are made from, or would be
/// taken for a frame of the input the next time.
void require_separate_files(const ResultFiles& results, const InputFiles& inputs);

}  // namespace holdfast::app
