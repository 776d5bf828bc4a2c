#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads an OFF file of text (OFF, COFF, NOFF, STOFF and their combinations): polygons, colours of vertices or faces.
/// `remarks` gets a line for what is not read. Throws Error(file).
Mesh load_off(const std::filesystem::path& path, double scale, std::vector<std::string>& remarks);

}  // namespace holdfast::io
