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
#include "io/color_range.hpp"
#include "io/material_file.hpp"
#include "io/mesh_assembly.hpp"
#include "io/named_file.hpp"
#include "io/numbers.hpp"
#include "io/obj_text.hpp"
#include "io/polygon.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using Color = std::array<std::uint8_t, 4>;

/// The material files that a line after mtllib names: one whose name may have blanks, or several.
std::vector<fs::path> material_files(const fs::path& model, const std::string& line) {
  std::vector<fs::path> files;
  const auto add = [&](const std::string& name) {
    const std::optional<fs::path> found = named_file(name, {model.parent_path()});
    if (found) files.push_back(*found);
    return found.has_value();
  };
  const std::string uncommented(without_comment(line));
  if (!add(line) && !add(uncommented)) {
    std::string_view rest = uncommented;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) add(std::string(word));
  }
  if (files.empty()) add(model.stem().string() + ".mtl");
  return files;
}

using Materials = std::map<std::string, NamedMaterial>;

/// The material that a model names; one of both names may have a comment behind it (3ds Max calls materials
/// "Material #25"). nullptr: there is none.
const NamedMaterial* find_material(const Materials& materials, const std::string& name) {
  auto found = materials.find(name);
  if (found == materials.end()) found = materials.find(std::string(without_comment(name)));
  if (found == materials.end()) {
    found = std::ranges::find_if(materials, [&](const auto& known) { return without_comment(known.first) == name; });
  }
  return found == materials.end() ? nullptr : &found->second;
}

/// The materials that the model's files define, by name, the first of a name. `remarks`: what is missing.
Materials materials_of(const fs::path& model, const ObjText& text, std::vector<std::string>& remarks) {
  Materials materials;
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
    if (!read.empty() && find_material(materials, name) == nullptr) {
      remarks.push_back(
          fmt::format("model '{}' uses the material '{}', which its material file lacks: it is taken as "
                      "plain",
                      model.string(), name));
    }
  }
  return materials;
}

fs::path texture_file(const fs::path& model, const NamedMaterial& material) {
  const fs::path folder = material.file.parent_path();
  const std::string& name = material.map->name;
  const bool whole = named_file(name, {folder, model.parent_path()}).has_value();
  return find_texture(model, whole ? name : std::string(without_comment(name)), {folder});
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
      if (with_texture) continue;
      looks.insert(material_color(face));
      if (plain.insert(face.material).second) {
        if (const auto reason = why_plain(face))
          remarks.push_back(fmt::format("model '{}': {}", path.string(), *reason));
      }
    }
    for (const Eigen::Array4f& color : text_.colors) range_.note(0, color.head<3>().maxCoeff());
    // One colour all over shows nothing that the outline does not; beside a texture it may be what exporters write for
    // surface that they know nothing of.
    if (textured) looks.erase(std::nullopt);
    by_material_ = text_.colors.empty() && looks.size() > 1;
    assembly_.emplace(textured, by_material_ || !text_.colors.empty());
  }

  Mesh make() {
    std::vector<Vertex> corners;
    std::vector<Eigen::Vector3f> positions;
    for (const ObjFace& face : text_.faces) {
      const bool textured = is_textured(face);
      const std::optional<Color> color = by_material_ && !textured ? material_color(face) : std::nullopt;
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
    return find_material(materials_, text_.material_names[face.material]);
  }

  const MaterialMap* map_of(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    return material != nullptr && material->map && !material->map->name.empty() ? &*material->map : nullptr;
  }

  /// Why a face is plain though its material has a picture; nothing where it has none.
  std::optional<std::string> why_plain(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    if (face.material == kNone && face.textured) {
      for (const auto& [name, defined] : materials_) {
        if (defined.map) {
          return fmt::format(
              "faces without usemtl have no material, the texture of '{}' is not seen on them: put the "
              "line 'usemtl {}' before them",
              name, name);
        }
      }
    }
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

  /// Nothing where the material has a picture: the colour beside it is not what it looks like.
  std::optional<Color> material_color(const ObjFace& face) const {
    const NamedMaterial* material = named(face);
    return material != nullptr && map_of(face) == nullptr ? material->color : std::nullopt;
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
      for (std::size_t i = 0; i < 3; ++i) {
        vertex.color[i] = color_byte(stored[static_cast<Eigen::Index>(i)], range_.full(i));
      }
      vertex.color[3] = color_byte(stored[3], 1);
    }
    return vertex;
  }

  const fs::path& path_;
  const ObjText& text_;
  Materials materials_;
  bool by_material_ = false;  ///< colours are those of materials
  ColorRange range_;          ///< of the file's colours of vertices
  std::optional<MeshAssembly> assembly_;
  std::map<std::pair<std::size_t, bool>, std::uint32_t> made_;  ///< name's index, textured -> the mesh's
};

}  // namespace

Mesh load_obj(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  const ObjText text = parse_obj(path, scale);
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
