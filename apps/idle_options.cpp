#include "idle_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

std::optional<std::string> first_given(const CLI::App& command, std::initializer_list<const char*> options) {
  for (const std::string name : options) {
    for (const CLI::Option* option : command.get_options()) {
      const bool meant = name.starts_with("--") ? option->check_name(name) : option->get_group() == name;
      if (meant && option->count() > 0) return option->get_name();
    }
  }
  return std::nullopt;
}

}  // namespace

void refuse_beside(const CLI::App& command, std::initializer_list<const char*> options, bool beside,
                   const std::string& what) {
  if (!beside) return;
  if (const auto option = first_given(command, options)) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} has no effect beside {}: leave one of them out", *option, what));
  }
}

void refuse_without(const CLI::App& command, std::initializer_list<const char*> options, bool with,
                    const std::string& what) {
  if (with) return;
  if (const auto option = first_given(command, options)) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} has no effect without {}: add that, or leave {} out", *option, what, *option));
  }
}

bool is_given(const CLI::App& command, const std::string& option) { return command.count(option) > 0; }

}  // namespace holdfast::app
