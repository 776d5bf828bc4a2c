#pragma once

#include <string>

namespace holdfast::app {

/// Throws Error(invalid_argument), "`option` needs a display (why): `instead`", when no window can be opened. Before
/// any use of a device: it forks.
void require_display(const std::string& option, const std::string& instead);

/// That error.
[[noreturn]] void refuse_without_display(const std::string& option, const std::string& why, const std::string& instead);

}  // namespace holdfast::app
