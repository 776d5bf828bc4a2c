#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::evaluation {

/// Which model belongs to which sequence, from command-line values `PATH` (any sequence) or `PREFIX=PATH` (sequences
/// whose name starts with PREFIX; the longest one wins).
class ModelChoice {
 public:
  /// Throws Error(invalid_argument) for a value without a path.
  explicit ModelChoice(const std::vector<std::string>& values);

  bool empty() const { return rules_.empty(); }

  /// Throws Error(invalid_argument) when no rule fits, Error(file) when the file is missing.
  const std::filesystem::path& for_sequence(const std::string& name) const;

 private:
  struct Rule {
    std::string prefix;
    std::filesystem::path path;
  };
  std::vector<Rule> rules_;
};

}  // namespace holdfast::evaluation
