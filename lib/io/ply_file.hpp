#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads a PLY file: text or binary, polygons and strips, texture coordinates and colours of vertices or of faces
/// (MeshLab's). `remarks` gets a line for what it lacks. Throws Error(file).
Mesh load_ply(const std::filesystem::path& path, double scale, std::vector<std::string>& remarks);

/// The textures that a PLY file's header names. Throws Error(file).
std::vector<std::string> ply_textures(const std::filesystem::path& path);

}  // namespace holdfast::io
