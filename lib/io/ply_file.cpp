#include "io/ply_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/mesh_assembly.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw Error(ErrorCode::file,
              fmt::format("model '{}' cannot be read ({}): is the file complete?", path.string(), reason));
}

enum class Encoding { text, little_endian, big_endian };

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type;  ///< set for lists
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
  std::vector<std::string> textures;
  std::size_t size = 0;  ///< bytes up to the data
};

Type parse_type(const std::string& word, const fs::path& path) {
  constexpr std::pair<std::string_view, Type> names[] = {
      {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
      {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
      {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
      {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};
  for (const auto& [name, type] : names) {
    if (word == name) {
      return type;
    }
  }
  fail(path, fmt::format("its header names an unknown type '{}'", word));
}

Header parse_header(const std::string& bytes, const fs::path& path) {
  Header header;
  std::istringstream lines(bytes.substr(0, std::min<std::size_t>(bytes.size(), 1 << 16)));
  std::string line;
  while (std::getline(lines, line)) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    std::istringstream words(line);
    std::string keyword;
    std::string word;
    words >> keyword;
    if (keyword == "format") {
      words >> word;
      header.encoding = word == "ascii"                  ? Encoding::text
                        : word == "binary_little_endian" ? Encoding::little_endian
                                                         : Encoding::big_endian;
    } else if (keyword == "comment") {
      words >> word;
      if (word == "TextureFile") {
        std::getline(words >> std::ws, word);
        header.textures.push_back(word);
      }
    } else if (keyword == "element") {
      Element element;
      words >> element.name >> element.count;
      if (!words || element.count > bytes.size()) {  // each takes a byte at least
        fail(path, fmt::format("its header's '{}' is not possible in {} bytes", line, bytes.size()));
      }
      header.elements.push_back(element);
    } else if (keyword == "property" && !header.elements.empty()) {
      Property property;
      words >> word;
      if (word == "list") {
        words >> word;
        property.count_type = parse_type(word, path);
        words >> word;
      }
      property.type = parse_type(word, path);
      words >> property.name;
      header.elements.back().properties.push_back(property);
    } else if (keyword == "end_header") {
      header.size = lines.eof() ? bytes.size() : static_cast<std::size_t>(lines.tellg());
      return header;
    }
  }
  fail(path, "its header has no end");
}

const Element* find_element(const Header& header, std::string_view name) {
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                  [name](const Element& element) { return element.name == name; });
  return found == header.elements.end() ? nullptr : &*found;
}

bool has_corner_coordinates(const Header& header) {
  const Element* face = find_element(header, "face");
  return face != nullptr && std::any_of(face->properties.begin(), face->properties.end(), [](const Property& property) {
           return property.count_type && property.name == "texcoord";
         });
}

/// The values after the header, one after the other.
class Values {
 public:
  Values(std::string_view data, Encoding encoding, const fs::path& path)
      : data_(data), encoding_(encoding), path_(path) {}

  double next(Type type) { return encoding_ == Encoding::text ? next_word() : next_bytes(type); }

  /// The values of one property: one, or as many as its list has.
  void next(const Property& property, std::vector<double>& values) {
    const double count = property.count_type ? next(*property.count_type) : 1;
    if (!(count >= 0 && count <= static_cast<double>(data_.size()))) {
      fail(path_, fmt::format("a list '{}' of {} values", property.name, count));
    }
    values.clear();
    for (double i = 0; i < count; ++i) {
      values.push_back(next(property.type));
    }
  }

 private:
  double next_word() {
    const std::size_t first = data_.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) {
      fail(path_, "it ends early");
    }
    data_.remove_prefix(first);
    double value = 0;
    const auto [end, error] = std::from_chars(data_.data(), data_.data() + data_.size(), value);
    if (error != std::errc()) {
      fail(path_, fmt::format("'{}' is not a number", data_.substr(0, data_.find_first_of(" \t\r\n")).substr(0, 20)));
    }
    data_.remove_prefix(static_cast<std::size_t>(end - data_.data()));
    return value;
  }

  template <class Stored>
  double next_stored() {
    char bytes[sizeof(Stored)];
    if (data_.size() < sizeof(Stored)) {
      fail(path_, "it ends early");
    }
    std::memcpy(bytes, data_.data(), sizeof(Stored));
    data_.remove_prefix(sizeof(Stored));
    const bool swapped = (encoding_ == Encoding::big_endian) != (std::endian::native == std::endian::big);
    if (swapped) {
      std::reverse(std::begin(bytes), std::end(bytes));
    }
    Stored value;
    std::memcpy(&value, bytes, sizeof(Stored));
    return static_cast<double>(value);
  }

  double next_bytes(Type type) {
    switch (type) {
      case Type::int8:
        return next_stored<std::int8_t>();
      case Type::uint8:
        return next_stored<std::uint8_t>();
      case Type::int16:
        return next_stored<std::int16_t>();
      case Type::uint16:
        return next_stored<std::uint16_t>();
      case Type::int32:
        return next_stored<std::int32_t>();
      case Type::uint32:
        return next_stored<std::uint32_t>();
      case Type::float32:
        return next_stored<float>();
      case Type::float64:
        return next_stored<double>();
    }
    fail(path_, "unknown type");
  }

  std::string_view data_;
  Encoding encoding_;
  const fs::path& path_;
};

std::uint8_t to_byte(double value, Type type) {
  const double scaled = type == Type::float32 || type == Type::float64 ? value * 255 : value;
  return static_cast<std::uint8_t>(std::lround(std::clamp(scaled, 0.0, 255.0)));
}

void set_vertex_property(Vertex& vertex, const Property& property, double value, double scale) {
  constexpr std::string_view axes[] = {"x", "y", "z"};
  constexpr std::string_view channels[] = {"red", "green", "blue", "alpha"};
  for (int i = 0; i < 3; ++i) {
    if (property.name == axes[i]) {
      vertex.position[i] = static_cast<float>(value * scale);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (property.name == channels[i]) {
      vertex.color[i] = to_byte(value, property.type);
    }
  }
}

std::vector<Vertex> read_vertices(Values& values, const Element& element, double scale) {
  std::vector<Vertex> vertices;
  std::vector<double> read;
  const bool with_alpha = std::any_of(element.properties.begin(), element.properties.end(),
                                      [](const Property& property) { return property.name == "alpha"; });
  for (std::size_t i = 0; i < element.count; ++i) {
    Vertex vertex;
    vertex.color[3] = with_alpha ? 0 : 255;
    for (const Property& property : element.properties) {
      values.next(property, read);
      if (!property.count_type) {
        set_vertex_property(vertex, property, read.front(), scale);
      }
    }
    vertices.push_back(vertex);
  }
  return vertices;
}

struct Face {
  std::vector<double> indices;
  std::vector<double> coordinates;  ///< u, v of each corner
  std::size_t texture = 0;
};

/// A convex polygon as a fan of triangles.
void add_face(MeshAssembly& assembly, const std::vector<Vertex>& vertices, const Face& face, std::size_t textures,
              const fs::path& path) {
  if (!face.coordinates.empty() && face.coordinates.size() != 2 * face.indices.size()) {
    fail(path,
         fmt::format("a face of {} corners has {} texture coordinates", face.indices.size(), face.coordinates.size()));
  }
  if (face.texture >= textures && !face.coordinates.empty()) {
    fail(path, fmt::format("a face refers to texture {}, but there are {}", face.texture, textures));
  }
  std::vector<Vertex> corners;
  for (std::size_t i = 0; i < face.indices.size(); ++i) {
    if (!(face.indices[i] >= 0 && face.indices[i] < static_cast<double>(vertices.size()))) {
      fail(path, fmt::format("a face refers to vertex {}, but there are {}", face.indices[i], vertices.size()));
    }
    Vertex corner = vertices[static_cast<std::size_t>(face.indices[i])];
    if (!face.coordinates.empty()) {
      corner.texture_coordinate = {static_cast<float>(face.coordinates[2 * i]),
                                   static_cast<float>(face.coordinates[2 * i + 1])};
    }
    corners.push_back(corner);
  }
  const std::size_t material = face.coordinates.empty() ? textures : face.texture;  // `textures`: the one without
  for (std::size_t i = 2; i < corners.size(); ++i) {
    assembly.add_triangle({corners[0], corners[i - 1], corners[i]}, static_cast<std::uint32_t>(material));
  }
}

Face read_face(Values& values, const Element& element) {
  Face face;
  std::vector<double> read;
  for (const Property& property : element.properties) {
    values.next(property, read);
    if (property.name == "vertex_indices" || property.name == "vertex_index") {
      face.indices = read;
    } else if (property.name == "texcoord") {
      face.coordinates = read;
    } else if (property.name == "texnumber" && !read.empty() && read.front() >= 0) {
      face.texture = static_cast<std::size_t>(read.front());
    }
  }
  return face;
}

}  // namespace

std::optional<Mesh> load_ply_with_corner_coordinates(const fs::path& path, double scale) {
  const std::string bytes = read_text_file(path, "model");
  const Header header = parse_header(bytes, path);
  if (!has_corner_coordinates(header)) {
    return std::nullopt;
  }
  const Element* vertex_element = find_element(header, "vertex");
  const bool with_colors =
      vertex_element != nullptr && std::any_of(vertex_element->properties.begin(), vertex_element->properties.end(),
                                               [](const Property& property) { return property.name == "red"; });
  MeshAssembly assembly(true, with_colors);
  for (const std::string& texture : header.textures) {
    assembly.add_material({fs::path(texture).stem().string(), load_texture(find_texture(path, texture))});
  }

  Values values(std::string_view(bytes).substr(header.size), header.encoding, path);
  std::vector<Vertex> vertices;
  std::vector<double> ignored;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      vertices = read_vertices(values, element, scale);
      continue;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      if (element.name == "face") {
        add_face(assembly, vertices, read_face(values, element), header.textures.size(), path);
      } else {
        for (const Property& property : element.properties) {
          values.next(property, ignored);
        }
      }
    }
  }
  Mesh mesh = assembly.take();
  if (std::any_of(mesh.triangle_materials.begin(), mesh.triangle_materials.end(),
                  [&header](std::uint32_t material) { return material == header.textures.size(); })) {
    mesh.materials.push_back({"untextured", {}});
  }
  return mesh;
}

}  // namespace holdfast::io
