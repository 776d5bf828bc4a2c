#pragma once

#include <filesystem>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads an STL file, text or binary; of the latter with colours of facets. Throws Error(file).
Mesh load_stl(const std::filesystem::path& path, double scale);

}  // namespace holdfast::io
