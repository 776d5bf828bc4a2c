#pragma once

#include <string_view>

namespace holdfast {

/// Contents of a file of kernels/ as it was at build time, by file name; empty when there is none of that name.
std::string_view embedded_text(std::string_view name);

}  // namespace holdfast
