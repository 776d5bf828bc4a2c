#include "io/obj_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/material_file.hpp"
#include "io/mesh_assembly.hpp"
#include "io/named_file.hpp"
#include "io/numbers.hpp"
#include "io/polygon.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using Color = std::array<std::uint8_t, 4>;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// Colours of a file in which one is greater are numbers up to 255: shares of 1 are rounded up by less.
constexpr float kMostShare = 2;

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

/// What stands in an OBJ file.
struct ObjText {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Array4f> colors;  ///< empty, or one a position, as they stand there
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<ObjCorner> corners;
  std::vector<ObjFace> faces;
  std::vector<std::string> material_names;  ///< in the order of their first use
  std::vector<std::string> libraries;       ///< the lines after mtllib
};

class ObjParser {
 public:
  ObjParser(const fs::path& path, double scale) : path_(path), scale_(scale) {}

  ObjText parse() {
    const std::string bytes = read_text_file(path_, "model");
    std::string_view text = bytes;
    std::string joined;
    for (std::string_view line; next_line(text, line); ++line_) {
      joined.clear();
      while (line.ends_with('\\') && !text.empty()) {  // goes on in the next line
        joined.append(line.substr(0, line.size() - 1)).append(" ");
        next_line(text, line);
        ++line_;
      }
      if (!joined.empty()) {
        joined.append(line);
        line = joined;
      }
      parse_line(line);
    }
    return std::move(read_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(ErrorCode::file, fmt::format("model '{}' cannot be read (line {}: {}): is the file complete?",
                                             path_.string(), line_, reason));
  }

  void parse_line(std::string_view line) {
    const std::string keyword = lower(next_word(line));
    if (keyword == "v") {
      add_position(line);
    } else if (keyword == "vt") {
      const std::size_t count = numbers(line.substr(0, line.find('#')), 3);
      if (count == 0) fail("a texture coordinate without numbers");
      read_.coordinates.push_back({static_cast<float>(values_[0]), count > 1 ? static_cast<float>(values_[1]) : 0.0F});
    } else if (keyword == "f" || keyword == "fo") {
      add_face(line.substr(0, line.find('#')));
    } else if (keyword == "usemtl") {
      use(std::string(trimmed(line)));
    } else if (keyword == "mtllib") {
      read_.libraries.emplace_back(trimmed(line));
    }
  }

  std::size_t numbers(std::string_view line, std::size_t most) {
    std::size_t count = 0;
    for (std::string_view word = next_word(line); !word.empty() && count < most; word = next_word(line)) {
      const std::optional<double> number = parse_number(word);
      if (!number) fail(fmt::format("'{}' is not a number", word.substr(0, 20)));
      values_[count++] = *number;
    }
    return count;
  }

  /// x y z, then nothing, a weight, or a colour.
  void add_position(std::string_view line) {
    const std::size_t count = numbers(line.substr(0, line.find('#')), 7);
    if (count < 3) fail(fmt::format("a vertex of {} numbers", count));
    const double weight = count == 4 && values_[3] != 0 ? values_[3] : 1;
    read_.positions.push_back((Eigen::Vector3d(values_[0], values_[1], values_[2]) * (scale_ / weight)).cast<float>());
    if (count < 6 && read_.colors.empty()) return;
    read_.colors.resize(read_.positions.size(), Eigen::Array4f::Zero());
    if (count < 6) return;
    read_.colors.back() << static_cast<float>(values_[3]), static_cast<float>(values_[4]),
        static_cast<float>(values_[5]), 1;
  }

  /// The index that a corner names, from 1 or, below 0, from the last on; nothing where it names none.
  std::optional<std::size_t> index(std::string_view word, std::size_t count, const char* what) const {
    if (word.empty()) return std::nullopt;
    const std::optional<double> number = parse_number(word);
    if (!number || *number != std::floor(*number)) {
      fail(fmt::format("'{}' is no corner of a face", word.substr(0, 20)));
    }
    const double from_zero = *number < 0 ? static_cast<double>(count) + *number : *number - 1;
    if (!(from_zero >= 0 && from_zero < static_cast<double>(count))) {
      fail(fmt::format("a face refers to {} {}, but there are {}", what, *number, count));
    }
    return static_cast<std::size_t>(from_zero);
  }

  void add_face(std::string_view line) {
    ObjFace face{read_.corners.size(), 0, material_, true};
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const auto position = index(word.substr(0, slash), read_.positions.size(), "vertex");
      if (!position) fail(fmt::format("'{}' is no corner of a face", word.substr(0, 20)));
      std::string_view second = word.substr(std::min(slash + 1, word.size()));
      second = second.substr(0, second.find('/'));
      const auto coordinate = index(second, read_.coordinates.size(), "texture coordinate");
      face.textured = face.textured && coordinate.has_value();
      read_.corners.push_back({*position, coordinate.value_or(kNone)});
      ++face.count;
    }
    read_.faces.push_back(face);
  }

  void use(const std::string& name) {
    const auto [known, is_new] = materials_.try_emplace(name, read_.material_names.size());
    if (is_new) read_.material_names.push_back(name);
    material_ = known->second;
  }

  const fs::path& path_;
  double scale_;
  int line_ = 1;
  std::array<double, 7> values_{};
  std::map<std::string, std::size_t> materials_;
  std::size_t material_ = kNone;
  ObjText read_;
};

/// The material files that a line after mtllib names: one whose name may have blanks, or several.
std::vector<fs::path> material_files(const fs::path& model, const std::string& line) {
  std::vector<fs::path> files;
  const auto add = [&](const std::string& name) {
    const std::optional<fs::path> found = named_file(name, {model.parent_path()});
    if (found) files.push_back(*found);
    return found.has_value();
  };
  if (!add(line)) {
    std::string_view rest = line;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) add(std::string(word));
  }
  if (files.empty()) add(model.stem().string() + ".mtl");
  return files;
}

/// The materials that the model's files define, by name, the first of a name. `remarks`: what is missing.
std::map<std::string, NamedMaterial> materials_of(const fs::path& model, const ObjText& text,
                                                  std::vector<std::string>& remarks) {
  std::map<std::string, NamedMaterial> materials;
  std::set<fs::path> read;
  for (const std::string& line : text.libraries) {
    const std::vector<fs::path> files = material_files(model, line);
    if (files.empty()) {
      remarks.push_back(
          fmt::format("the material file '{}' of model '{}' is not beside it: copy it there, with its pictures", line,
                      model.string()));
    }
    for (const fs::path& file : files) {
      if (!read.insert(file).second) continue;
      for (NamedMaterial& material : load_materials(file, remarks)) {
        materials.try_emplace(material.name, std::move(material));
      }
    }
  }
  if (text.libraries.empty() && !text.material_names.empty()) {
    remarks.push_back(
        fmt::format("model '{}' uses the material '{}', but names no material file (mtllib): it is taken "
                    "as plain",
                    model.string(), text.material_names.front()));
  }
  for (const std::string& name : text.material_names) {
    if (!read.empty() && !materials.contains(name)) {
      remarks.push_back(
          fmt::format("model '{}' uses the material '{}', which its material file lacks: it is taken as "
                      "plain",
                      model.string(), name));
    }
  }
  return materials;
}

fs::path texture_file(const fs::path& model, const NamedMaterial& material) {
  return find_texture(model, material.map->name, {material.file.parent_path()});
}

/// Makes the mesh of what the files say.
class ObjMesh {
 public:
  ObjMesh(const fs::path& path, const ObjText& text, std::vector<std::string>& remarks)
      : path_(path), text_(text), materials_(materials_of(path, text, remarks)) {
    std::set<std::optional<Color>> looks;
    std::set<std::size_t> plain;
    bool textured = false;
    for (const ObjFace& face : text_.faces) {
      const bool with_texture = is_textured(face);
      textured = textured || with_texture;
      looks.insert(material_color(face));
      if (!with_texture && plain.insert(face.material).second) {
        if (const auto reason = why_plain(face))
          remarks.push_back(fmt::format("model '{}': {}", path.string(), *reason));
      }
    }
    for (const Eigen::Array4f& color : text_.colors) most_ = std::max(most_, color.maxCoeff());
    // One colour all over shows nothing that the outline does not; beside a texture it may be what exporters write for
    // surface that they know nothing of.
    by_material_ = !textured && text_.colors.empty() && looks.size() > 1;
    assembly_.emplace(textured, by_material_ || !text_.colors.empty());
  }

  Mesh make() {
    std::vector<Vertex> corners;
    std::vector<Eigen::Vector3f> positions;
    for (const ObjFace& face : text_.faces) {
      const bool textured = is_textured(face);
      const std::optional<Color> color = by_material_ ? material_color(face) : std::nullopt;
      const std::uint32_t material = material_of(face, textured);
      corners.clear();
      positions.clear();
      for (std::size_t i = face.first; i < face.first + face.count; ++i) {
        corners.push_back(vertex_of(text_.corners[i], textured ? map_of(face) : nullptr, color));
        positions.push_back(corners.back().position);
      }
      for (const auto& [a, b, c] : triangles_of_polygon(positions)) {
        assembly_->add_triangle({corners[a], corners[b], corners[c]}, material);
      }
    }
    return assembly_->take();
  }

 private:
  const NamedMaterial* named(const ObjFace& face) const {
    if (face.material == kNone) return nullptr;
    const auto found = materials_.find(text_.material_names[face.material]);
    return found == materials_.end() ? nullptr : &found->second;
  }

  const MaterialMap* map_of(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    return material != nullptr && material->map && !material->map->name.empty() ? &*material->map : nullptr;
  }

  /// Why a face is plain though its material has a picture; nothing where it has none.
  std::optional<std::string> why_plain(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    if (material == nullptr) return std::nullopt;
    if (map_of(face) != nullptr) {
      return fmt::format("faces of material '{}' have no texture coordinates, its texture is not seen on them",
                         material->name);
    }
    if (material->other_map.empty()) return std::nullopt;
    return fmt::format("material '{}' has a picture as {}, which is not supported: name it as map_Kd", material->name,
                       material->other_map);
  }

  bool is_textured(const ObjFace& face) const { return face.textured && map_of(face) != nullptr; }

  std::optional<Color> material_color(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    return material != nullptr ? material->color : std::nullopt;
  }

  std::uint32_t material_of(const ObjFace& face, bool textured) {
    const auto [known, is_new] = made_.try_emplace({face.material, textured}, 0);
    if (is_new) {
      const std::string name = face.material != kNone ? text_.material_names[face.material] : "";
      known->second = textured ? assembly_->add_picture(texture_file(path_, *named(face)), name, map_of(face)->wrapping)
                               : assembly_->add_material({name, {}});
    }
    return known->second;
  }

  Vertex vertex_of(const ObjCorner& corner, const MaterialMap* map, const std::optional<Color>& color) const {
    Vertex vertex;
    vertex.position = text_.positions[corner.position];
    if (corner.coordinate != kNone) {
      vertex.texture_coordinate = text_.coordinates[corner.coordinate];
      if (map != nullptr) vertex.texture_coordinate = vertex.texture_coordinate.cwiseProduct(map->scale) + map->offset;
    }
    if (color) {
      vertex.color = *color;
    } else if (corner.position < text_.colors.size()) {
      const Eigen::Array4f& stored = text_.colors[corner.position];
      const float whole = most_ > kMostShare ? 1 : 255;
      for (Eigen::Index i = 0; i < 3; ++i) vertex.color[static_cast<std::size_t>(i)] = to_byte(stored[i] * whole);
      vertex.color[3] = to_byte(stored[3] * 255);
    }
    return vertex;
  }

  static std::uint8_t to_byte(float value) {
    return static_cast<std::uint8_t>(std::lround(std::isfinite(value) ? std::clamp(value, 0.0F, 255.0F) : 0.0F));
  }

  const fs::path& path_;
  const ObjText& text_;
  std::map<std::string, NamedMaterial> materials_;
  bool by_material_ = false;  ///< colours are those of materials
  float most_ = 0;            ///< of the file's colours of vertices
  std::optional<MeshAssembly> assembly_;
  std::map<std::pair<std::size_t, bool>, std::uint32_t> made_;  ///< name's index, textured -> the mesh's
};

}  // namespace

Mesh load_obj(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  const ObjText text = ObjParser(path, scale).parse();
  return ObjMesh(path, text, remarks).make();
}

std::vector<fs::path> obj_files(const fs::path& path) {
  std::vector<fs::path> files;
  std::vector<std::string> ignored;
  const std::string bytes = read_text_file(path, "model");
  std::string_view text = bytes;
  for (std::string_view line; next_line(text, line);) {
    if (next_word(line) != "mtllib") continue;
    for (const fs::path& file : material_files(path, std::string(trimmed(line)))) {
      files.push_back(file);
      for (const NamedMaterial& material : load_materials(file, ignored)) {
        if (!material.map) continue;
        try {
          files.push_back(texture_file(path, material));
        } catch (const Error&) {
          // Not there.
        }
      }
    }
  }
  return files;
}

}  // namespace holdfast::io
