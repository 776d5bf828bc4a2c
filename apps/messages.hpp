#pragma once

#include <optional>
#include <string>

namespace holdfast::app {

/// The text with line breaks and runs of blanks made single blanks.
std::string one_line(const std::string& text);

/// "holdfast: ..." as one line on stderr.
void print_note(const std::string& message);

/// "holdfast: error: ..." as one line on stderr.
void print_error(const std::string& message);

/// "holdfast: warning: ..." as one line on stderr.
void print_warning(const std::string& message);
/// The same, if there is anything to warn of.
void warn_if(const std::optional<std::string>& doubt);

}  // namespace holdfast::app
