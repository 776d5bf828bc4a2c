#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace holdfast::io {

/// What the data of a PLY file are.
struct PlyHeader {
  enum class Encoding { text, little_endian, big_endian };
  enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

  struct Property {
    std::string name;  ///< as all names in lower case
    Type type = Type::float32;
    std::optional<Type> count_type;  ///< set for lists
  };

  struct Element {
    std::string name;
    std::size_t count = 0;  ///< at most the file's bytes
    std::vector<Property> properties;
  };

  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
  std::vector<std::string> textures;
  std::size_t size = 0;  ///< bytes up to the data
};

/// Reads the header of a file with these contents; `path` is for messages. Throws Error(file).
PlyHeader parse_ply_header(const std::string& bytes, const std::filesystem::path& path);

}  // namespace holdfast::io
