#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// Reads a glTF 2.0 file (.gltf, .glb): triangles of its scene, base colours, their textures and how they are laid out
/// (KHR_texture_transform). `remarks` gets a line for what is not supported. Throws Error(file), and Error(model) where
/// the file needs an extension that is not supported.
Mesh load_gltf(const std::filesystem::path& path, double scale, std::vector<std::string>& remarks);

/// The files that a glTF file names and that are there. Throws Error(file).
std::vector<std::filesystem::path> gltf_files(const std::filesystem::path& path);

}  // namespace holdfast::io
