#pragma once

#include <filesystem>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads an OFF file of text (OFF, COFF, NOFF, STOFF and their combinations): polygons, colours of vertices or faces.
/// Throws Error(file).
Mesh load_off(const std::filesystem::path& path, double scale);

}  // namespace holdfast::io
