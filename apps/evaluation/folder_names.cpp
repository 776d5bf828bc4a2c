#include "evaluation/folder_names.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace holdfast::evaluation {
namespace {

namespace fs = std::filesystem;

/// Without a slash at its end, which would make the last name empty.
fs::path whole_path(const fs::path& folder) {
  const fs::path path = fs::weakly_canonical(folder);
  return path.has_filename() ? path : path.parent_path();
}

/// The last `parts` names of a path, joined.
std::string name_of(const fs::path& folder, int parts) {
  fs::path rest = whole_path(folder);
  std::string name = rest.filename().string();
  for (int i = 1; i < parts && rest.has_parent_path(); ++i) {
    rest = rest.parent_path();
    name = rest.filename().string() + "_" + name;
  }
  return name;
}

}  // namespace

std::string folder_name(const fs::path& folder) { return name_of(folder, 1); }

std::vector<std::string> distinct_names(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const fs::path whole = whole_path(folders[i]);
    // As few of the folders above as tell it from every other folder.
    int parts = 1;
    for (const fs::path& other : folders) {
      if (whole_path(other) == whole) continue;
      while (name_of(other, parts) == name_of(whole, parts)) ++parts;
    }
    const std::string name = name_of(whole, parts);
    names.push_back(name);
    for (int again = 2; std::count(names.begin(), names.end(), names.back()) > 1; ++again) {
      names.back() = fmt::format("{}_{}", name, again);
    }
  }
  return names;
}

}  // namespace holdfast::evaluation
