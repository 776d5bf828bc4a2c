#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads an OBJ file with its material files and textures, and colours of vertices or materials. `remarks` gets a line
/// for what is missing or not supported. Throws Error(file).
Mesh load_obj(const std::filesystem::path& path, double scale, std::vector<std::string>& remarks);

/// The material files and textures that an OBJ file names and that are there. Throws Error(file).
std::vector<std::filesystem::path> obj_files(const std::filesystem::path& path);

}  // namespace holdfast::io
