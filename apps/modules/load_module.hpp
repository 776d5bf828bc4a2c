#pragma once

#include <string>

namespace holdfast::app {

/// `holdfast_<name>` of holdfast_<name>.so, a part of the program that is loaded when it is first wanted and then kept.
/// The program's run path leads to it. Throws Error(file), telling `purpose`, when it cannot be loaded.
const void* load_module(const std::string& name, const std::string& purpose);

}  // namespace holdfast::app
