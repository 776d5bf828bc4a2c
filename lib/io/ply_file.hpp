#pragma once

#include <filesystem>
#include <optional>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads a PLY file whose texture coordinates belong to the corners of faces, as MeshLab writes them; nothing for any
/// other PLY file. assimp keeps one coordinate a vertex and so tears the texture at every seam. Throws Error(file).
std::optional<Mesh> load_ply_with_corner_coordinates(const std::filesystem::path& path, double scale);

}  // namespace holdfast::io
