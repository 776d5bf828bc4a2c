#pragma once

#include <initializer_list>
#include <string>

namespace CLI {
class App;
}

/// Options that would do nothing are refused: whoever gives one expects something of it.
namespace holdfast::app {

/// If `beside` holds, Error(invalid_argument) for the first of `options` that was given: "--speed has no effect beside
/// --trajectory: leave one of them out". An option may be a whole group of the help, by its title.
void refuse_beside(const CLI::App& command, std::initializer_list<const char*> options, bool beside,
                   const std::string& what);

/// The same unless `with` holds: "--ease has no effect without --motion sharp: add that, or leave --ease out".
void refuse_without(const CLI::App& command, std::initializer_list<const char*> options, bool with,
                    const std::string& what);

/// If `option` was given.
bool is_given(const CLI::App& command, const std::string& option);

}  // namespace holdfast::app
