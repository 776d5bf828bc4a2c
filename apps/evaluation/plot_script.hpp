#pragma once

#include <string_view>

namespace holdfast::evaluation {

/// A script of this folder, embedded at build time so that an installed program needs no path to it. Empty for an
/// unknown name.
std::string_view plot_script(std::string_view name);

}  // namespace holdfast::evaluation
