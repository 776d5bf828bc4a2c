#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::evaluation {

/// A folder's own name, also where its path ends with a slash or is the working folder.
std::string folder_name(const std::filesystem::path& folder);

/// Names under which the results of these folders can stand beside each other: a folder's own where no other has it,
/// else with those of the folders above that tell it apart, or a number where it is the same folder again.
std::vector<std::string> distinct_names(const std::vector<std::filesystem::path>& folders);

}  // namespace holdfast::evaluation
