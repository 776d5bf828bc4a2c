#include "evaluation/model_choice.hpp"

#include <fmt/core.h>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {

ModelChoice::ModelChoice(const std::vector<std::string>& values) {
  for (const std::string& value : values) {
    const std::size_t equals = value.find('=');
    // A path may hold an equals sign itself.
    if (equals == std::string::npos || std::filesystem::exists(value)) {
      rules_.push_back({"", value});
    } else {
      rules_.push_back({value.substr(0, equals), value.substr(equals + 1)});
    }
    if (rules_.back().path.empty()) {
      throw Error(ErrorCode::invalid_argument, fmt::format("--model '{}': PATH or PREFIX=PATH is needed", value));
    }
  }
}

const std::filesystem::path& ModelChoice::for_sequence(const std::string& name) const {
  const Rule* best = nullptr;
  for (const Rule& rule : rules_) {
    if (name.starts_with(rule.prefix) && (!best || rule.prefix.size() >= best->prefix.size())) {
      best = &rule;
    }
  }
  if (!best) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("no model for sequence '{}': add --model {}=PATH or --model PATH", name, name));
  }
  if (!std::filesystem::is_regular_file(best->path)) {
    throw Error(ErrorCode::file, fmt::format("{}: no such model file (for sequence '{}')", best->path.string(), name));
  }
  return best->path;
}

}  // namespace holdfast::evaluation
