#pragma once

#include <string_view>

namespace holdfast::io {

/// True where a PNG's chunks are all there, with the sums that belong to them where the picture needs them: libpng
/// writes to stderr where they are not.
bool is_whole_png(std::string_view bytes);

}  // namespace holdfast::io
