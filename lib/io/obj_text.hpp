#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace holdfast::io {

/// No index.
inline constexpr std::size_t kNone = static_cast<std::size_t>(-1);

struct ObjCorner {
  std::size_t position = 0;
  std::size_t coordinate = kNone;
};

struct ObjFace {
  std::size_t first = 0;  ///< of its corners
  std::size_t count = 0;
  std::size_t material = kNone;  ///< index into ObjText::material_names
  bool textured = false;         ///< all corners have texture coordinates
};

/// The contents of an OBJ file.
struct ObjText {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Array4f> colors;  ///< empty, or one a position, as they stand there
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<ObjCorner> corners;
  std::vector<ObjFace> faces;
  std::vector<std::string> material_names;  ///< in the order of their first use
  std::vector<std::string> libraries;       ///< the lines after mtllib
};

/// Positions are multiplied by `scale`. Throws Error(file).
ObjText parse_obj(const std::filesystem::path& path, double scale);

}  // namespace holdfast::io
