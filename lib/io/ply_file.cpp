#include "io/ply_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "holdfast/io.hpp"
#include "io/color_range.hpp"
#include "io/mesh_assembly.hpp"
#include "io/model_fault.hpp"
#include "io/named_file.hpp"
#include "io/ply_header.hpp"
#include "io/ply_values.hpp"
#include "io/polygon.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using Type = PlyHeader::Type;
using Property = PlyHeader::Property;
using Element = PlyHeader::Element;

const Element* find_element(const PlyHeader& header, std::string_view name) {
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                  [name](const Element& element) { return element.name == name; });
  return found == header.elements.end() ? nullptr : &*found;
}

/// Whether an element has a property of one of these names, a list or not.
bool has_property(const Element& element, std::span<const std::string_view> names, bool list) {
  return std::any_of(element.properties.begin(), element.properties.end(), [&](const Property& property) {
    return property.count_type.has_value() == list &&
           std::find(names.begin(), names.end(), property.name) != names.end();
  });
}

enum class Meaning { nothing, x, y, z, u, v, red, green, blue, alpha };

/// What a property that is no list says of its vertex or face; exporters differ in names.
Meaning meaning_of(const Property& property) {
  constexpr std::pair<std::string_view, Meaning> names[] = {{"x", Meaning::x},
                                                            {"y", Meaning::y},
                                                            {"z", Meaning::z},
                                                            {"s", Meaning::u},
                                                            {"t", Meaning::v},
                                                            {"u", Meaning::u},
                                                            {"v", Meaning::v},
                                                            {"texture_u", Meaning::u},
                                                            {"texture_v", Meaning::v},
                                                            {"texture_s", Meaning::u},
                                                            {"texture_t", Meaning::v},
                                                            {"u0", Meaning::u},
                                                            {"v0", Meaning::v},
                                                            {"s0", Meaning::u},
                                                            {"t0", Meaning::v},
                                                            {"red", Meaning::red},
                                                            {"green", Meaning::green},
                                                            {"blue", Meaning::blue},
                                                            {"alpha", Meaning::alpha},
                                                            {"r", Meaning::red},
                                                            {"g", Meaning::green},
                                                            {"b", Meaning::blue},
                                                            {"a", Meaning::alpha},
                                                            {"diffuse_red", Meaning::red},
                                                            {"diffuse_blue", Meaning::blue},
                                                            {"diffuse_green", Meaning::green},
                                                            {"diffuse_alpha", Meaning::alpha}};
  for (const auto& [name, meaning] : names) {
    if (!property.count_type && property.name == name) {
      return meaning;
    }
  }
  return Meaning::nothing;
}

/// A channel of a colour: red to alpha as 0 to 3.
std::size_t channel_of(Meaning meaning) {
  return static_cast<std::size_t>(meaning) - static_cast<std::size_t>(Meaning::red);
}

bool has(const Element& element, Meaning meaning) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [meaning](const Property& property) { return meaning_of(property) == meaning; });
}

/// The way an element's colours are stored. Programs write any type, and full colour as 1, 255 or what the type can
/// hold: where the type leaves that open, the largest value tells. `values`: a copy, read ahead.
ColorRange range_of(PlyValues values, const Element& element) {
  const auto is_open = [](const Property& property) {
    return meaning_of(property) >= Meaning::red &&
           (property.type == Type::float32 || property.type == Type::float64 || property.type == Type::uint16);
  };
  ColorRange range;
  if (std::none_of(element.properties.begin(), element.properties.end(), is_open)) return range;
  std::vector<double> read;
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      values.next(property, read);
      if (is_open(property)) range.note(channel_of(meaning_of(property)), read.front());
    }
  }
  return range;
}

void set_vertex_property(Vertex& vertex, const Property& property, double value, double scale,
                         const ColorRange& range) {
  const Meaning meaning = meaning_of(property);
  const auto place = static_cast<std::size_t>(meaning);
  if (meaning >= Meaning::red) {
    const std::size_t channel = channel_of(meaning);
    const double full = property.type == Type::uint16 ? range.full_of_16_bits(channel)
                        : property.type == Type::float32 || property.type == Type::float64 ? range.full(channel)
                                                                                           : 255;
    vertex.color[channel] = color_byte(value, full);
  } else if (meaning >= Meaning::u) {
    vertex.texture_coordinate[meaning == Meaning::u ? 0 : 1] = static_cast<float>(value);
  } else if (meaning >= Meaning::x) {
    vertex.position[static_cast<Eigen::Index>(place) - static_cast<Eigen::Index>(Meaning::x)] =
        static_cast<float>(value * scale);
  }
}

std::vector<Vertex> read_vertices(PlyValues& values, const Element& element, double scale) {
  std::vector<Vertex> vertices;
  std::vector<double> read;
  const bool opaque = has(element, Meaning::red) && !has(element, Meaning::alpha);
  const ColorRange range = range_of(values, element);
  for (std::size_t i = 0; i < element.count; ++i) {
    Vertex vertex;
    vertex.color[3] = opaque ? 255 : 0;
    for (const Property& property : element.properties) {
      values.next(property, read);
      if (!property.count_type) {
        set_vertex_property(vertex, property, read.front(), scale, range);
      }
    }
    vertices.push_back(vertex);
  }
  return vertices;
}

struct Face {
  std::vector<double> indices;
  std::vector<double> coordinates;  ///< u, v of each corner; empty: those of its vertices
  double texture = 0;
  std::optional<std::array<std::uint8_t, 4>> color;  ///< of the whole face
};

constexpr std::array<std::string_view, 2> kIndexNames = {"vertex_indices", "vertex_index"};
constexpr std::array<std::string_view, 9> kCoordinateNames = {
    "texcoord", "texcoords", "tex_coord", "tex_coords", "texture_coordinates", "uv", "uvs", "st", "t"};

bool is_one_of(const Property& property, std::span<const std::string_view> names) {
  return property.count_type && std::find(names.begin(), names.end(), property.name) != names.end();
}

Face read_face(PlyValues& values, const Element& element, const ColorRange& range) {
  Face face;
  std::vector<double> read;
  Vertex colored;
  colored.color[3] = has(element, Meaning::alpha) ? 0 : 255;
  for (const Property& property : element.properties) {
    values.next(property, read);
    if (is_one_of(property, kIndexNames)) {
      face.indices = read;
    } else if (is_one_of(property, kCoordinateNames)) {
      face.coordinates = read;
    } else if (property.name == "texnumber" && !read.empty() && read.front() >= 0) {
      face.texture = read.front();
    } else if (meaning_of(property) >= Meaning::red) {
      set_vertex_property(colored, property, read.front(), 1, range);
    }
  }
  if (has(element, Meaning::red)) {
    face.color = colored.color;
  }
  return face;
}

/// Adds faces to a mesh, each checked.
class Faces {
 public:
  /// `materials`: of the textures, then the one without.
  Faces(MeshAssembly& assembly, const std::vector<std::uint32_t>& materials, bool textured_vertices,
        const fs::path& path)
      : assembly_(assembly),
        materials_(materials),
        textures_(materials.size() - 1),
        textured_vertices_(textured_vertices),
        path_(path) {}

  void add(const Face& face, const std::vector<Vertex>& vertices) {
    std::vector<double> coordinates = face.coordinates;
    if (!coordinates.empty() && coordinates.size() != 2 * face.indices.size()) {
      fail_model(
          path_,
          fmt::format("a face of {} corners has {} texture coordinates", face.indices.size(), coordinates.size()),
          kExportAnew);
    }
    const bool textured = textures_ > 0 && (textured_vertices_ || !coordinates.empty());
    if (textured && face.texture >= static_cast<double>(textures_)) {
      fail_model(path_, fmt::format("a face refers to texture {}, but there are {}", face.texture, textures_),
                 kExportAnew);
    }
    corners_.clear();
    positions_.clear();
    for (std::size_t i = 0; i < face.indices.size(); ++i) {
      Vertex corner = vertex(vertices, face.indices[i]);
      if (!coordinates.empty()) {
        corner.texture_coordinate = {static_cast<float>(coordinates[2 * i]),
                                     static_cast<float>(coordinates[2 * i + 1])};
      }
      corner.color = face.color.value_or(corner.color);
      positions_.push_back(corner.position);
      corners_.push_back(corner);
    }
    const std::uint32_t material = materials_[textured ? static_cast<std::size_t>(face.texture) : textures_];
    for (const auto& [a, b, c] : triangles_of_polygon(positions_)) {
      assembly_.add_triangle({corners_[a], corners_[b], corners_[c]}, material);
    }
  }

  /// Triangles that share two corners with the one before; -1 ends a strip.
  void add_strips(const std::vector<double>& indices, const std::vector<Vertex>& vertices) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] < 0) {
        begin = i + 1;
      } else if (i >= begin + 2) {
        const bool odd = (i - begin) % 2 != 0;
        Face face;
        face.indices = {indices[odd ? i - 1 : i - 2], indices[odd ? i - 2 : i - 1], indices[i]};
        add(face, vertices);
      }
    }
  }

 private:
  const Vertex& vertex(const std::vector<Vertex>& vertices, double index) const {
    if (!(index >= 0 && index < static_cast<double>(vertices.size()))) {
      fail_model(path_, fmt::format("a face refers to vertex {}, but there are {}", index, vertices.size()),
                 kExportAnew);
    }
    return vertices[static_cast<std::size_t>(index)];
  }

  MeshAssembly& assembly_;
  const std::vector<std::uint32_t>& materials_;
  std::size_t textures_;
  bool textured_vertices_;
  const fs::path& path_;
  std::vector<Vertex> corners_;
  std::vector<Eigen::Vector3f> positions_;
};

void read_element(PlyValues& values, const Element& element, const std::vector<Vertex>& vertices, Faces& faces) {
  const bool are_faces = element.name == "face";
  const ColorRange range = are_faces ? range_of(values, element) : ColorRange();
  std::vector<double> read;
  for (std::size_t i = 0; i < element.count; ++i) {
    if (are_faces) {
      faces.add(read_face(values, element, range), vertices);
      continue;
    }
    for (const Property& property : element.properties) {
      values.next(property, read);
      if (element.name == "tristrips" && is_one_of(property, kIndexNames)) {
        faces.add_strips(read, vertices);
      }
    }
  }
}

}  // namespace

std::vector<std::string> ply_textures(const fs::path& path) {
  return parse_ply_header(read_text_file(path, "model"), path).textures;
}

Mesh load_ply(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  const std::string bytes = read_text_file(path, "model");
  const PlyHeader header = parse_ply_header(bytes, path);
  const Element* vertex_element = find_element(header, "vertex");
  const Element* face_element = find_element(header, "face");
  const auto vertices_have = [&](Meaning meaning) {
    return vertex_element != nullptr && has(*vertex_element, meaning);
  };
  const bool textured_vertices = vertices_have(Meaning::u) && vertices_have(Meaning::v);
  const bool textured_faces = face_element != nullptr && has_property(*face_element, kCoordinateNames, true);
  const bool with_colors = vertices_have(Meaning::red) || (face_element != nullptr && has(*face_element, Meaning::red));
  const bool with_coordinates = textured_vertices || textured_faces;
  if (!(vertices_have(Meaning::x) && vertices_have(Meaning::y) && vertices_have(Meaning::z))) {
    fail_model(path, "its header has no element 'vertex' with the properties x, y and z", kExportAnew);
  }
  if (face_element != nullptr && face_element < vertex_element) {
    fail_model(path, "its faces stand before its vertices, which is not supported",
               "export it with the vertices first");
  }
  if (!with_coordinates && !header.textures.empty()) {
    remarks.push_back(fmt::format(
        "model '{}' names the texture '{}', but no coordinates (s and t of vertices, or texcoord of faces): "
        "it is taken without",
        path.string(), header.textures.front()));
  }
  if (with_coordinates && header.textures.empty()) {
    remarks.push_back(
        fmt::format("model '{}' has texture coordinates but names no texture: add the line 'comment TextureFile NAME' "
                    "to its header",
                    path.string()));
  }
  MeshAssembly assembly(with_coordinates && !header.textures.empty(), with_colors);
  std::vector<std::uint32_t> materials;
  std::uint32_t untextured = 0;
  for (const std::string& texture : header.textures) {
    if (!with_coordinates) break;
    materials.push_back(assembly.add_picture(find_texture(path, texture), fs::path(texture).stem().string()));
    untextured = std::max(untextured, materials.back() + 1);
  }
  materials.push_back(untextured);

  PlyValues values(std::string_view(bytes).substr(header.size), header.encoding, path);
  Faces faces(assembly, materials, textured_vertices, path);
  std::vector<Vertex> vertices;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      vertices = read_vertices(values, element, scale);
    } else {
      read_element(values, element, vertices, faces);
    }
  }
  Mesh mesh = assembly.take();
  if (std::any_of(mesh.triangle_materials.begin(), mesh.triangle_materials.end(),
                  [untextured](std::uint32_t material) { return material == untextured; })) {
    mesh.materials.push_back({"untextured", {}});
  }
  return mesh;
}

}  // namespace holdfast::io
