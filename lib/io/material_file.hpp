#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh_assembly.hpp"

namespace holdfast::io {

/// The picture of a material in an MTL file (map_Kd) and how it is laid out.
struct MaterialMap {
  std::string name;  ///< as it stands there
  Eigen::Vector2f scale{1, 1};
  Eigen::Vector2f offset{0, 0};
  Wrapping wrapping;
};

/// A material of an MTL file, as far as it is read.
struct NamedMaterial {
  std::string name;
  std::filesystem::path file;                        ///< the MTL file
  std::optional<std::array<std::uint8_t, 4>> color;  ///< Kd
  std::optional<MaterialMap> map;
  std::string other_map;  ///< another map that shows what it looks like, as map_Ka; the last
};

/// Reads an MTL file; `remarks` gets a line for each option that is not supported. Throws Error(file).
std::vector<NamedMaterial> load_materials(const std::filesystem::path& path, std::vector<std::string>& remarks);

}  // namespace holdfast::io
