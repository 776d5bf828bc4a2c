#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/text_file.hpp"
#include "io/texture_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

/// OBJ and MTL separate words by blanks, so names that they refer to must not contain any.
std::string without_blanks(std::string name) {
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= ' ') {
      c = '_';
    }
  }
  return name;
}

/// What stands before the extension of the files beside an OBJ.
std::string companion_stem(const fs::path& path) { return without_blanks(path.stem().string()); }

/// The materials' own names where they are set and tell them apart.
std::vector<std::string> material_names(const Mesh& mesh) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    std::string name = without_blanks(mesh.materials[i].name);
    if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) {
      name = fmt::format("{}_material_{}", name, i);
    }
    names.push_back(name);
  }
  return names;
}

/// A vertex of unknown colour, below a texture or not, has none; where textures are laid over the others', these are
/// written all the same.
std::string vertex_line(const Mesh& mesh, std::size_t i) {
  const Eigen::Vector3f& p = mesh.positions[i];
  if (mesh.colors.empty() || mesh.colors[i][3] == 0) {
    return fmt::format("v {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  }
  const auto& [r, g, b, a] = mesh.colors[i];
  return fmt::format("v {:.9g} {:.9g} {:.9g} {:.6f} {:.6f} {:.6f}\n", p.x(), p.y(), p.z(), r / 255.0, g / 255.0,
                     b / 255.0);
}

}  // namespace

void save_model(const fs::path& path, const Mesh& mesh) {
  mesh.validate();
  if (path.extension() != ".obj") {
    throw Error(
        ErrorCode::invalid_argument,
        fmt::format("'{}' cannot be written: models are saved as OBJ, give a name ending in .obj", path.string()));
  }
  for (const auto& color : mesh.colors) {
    if (color[3] != 255 && color[3] != 0) {
      throw Error(ErrorCode::invalid_argument,
                  fmt::format("'{}' cannot be written: OBJ cannot hold vertex colours with alpha, use "
                              "a texture to mark unseen surface",
                              path.string()));
    }
  }
  const std::string stem = companion_stem(path);
  const bool with_coordinates = !mesh.texture_coordinates.empty();
  const std::vector<std::string> names = material_names(mesh);
  std::string obj = "# units: metres\n";
  auto out = std::back_inserter(obj);
  if (!mesh.materials.empty()) {
    std::string mtl;
    for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
      fmt::format_to(std::back_inserter(mtl), "newmtl {}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\n", names[i]);
      if (!mesh.materials[i].texture.empty()) {
        const std::string texture =
            mesh.materials.size() == 1 ? fmt::format("{}.png", stem) : fmt::format("{}_{}.png", stem, i);
        save_texture(path.parent_path() / texture, mesh.materials[i].texture);
        fmt::format_to(std::back_inserter(mtl), "map_Kd {}\n", texture);
      }
    }
    write_text_file(path.parent_path() / (stem + ".mtl"), mtl);
    fmt::format_to(out, "mtllib {}.mtl\n", stem);
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    obj += vertex_line(mesh, i);
  }
  for (const Eigen::Vector2f& uv : mesh.texture_coordinates) {
    fmt::format_to(out, "vt {:.9g} {:.9g}\n", uv.x(), uv.y());
  }
  std::size_t current_material = mesh.materials.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[i];
    if (material != current_material && material < mesh.materials.size()) {
      fmt::format_to(out, "usemtl {}\n", names[material]);
      current_material = material;
    }
    const auto& [a, b, c] = mesh.triangles[i];
    if (with_coordinates) {
      fmt::format_to(out, "f {0}/{0} {1}/{1} {2}/{2}\n", a + 1, b + 1, c + 1);
    } else {
      fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
    }
  }
  write_text_file(path, obj);
}

bool is_file_of_model(const fs::path& path, const fs::path& file) {
  const std::string stem = companion_stem(path), name = file.stem().string();
  const fs::path extension = file.extension();
  const bool numbered = name.starts_with(stem + "_") && name.size() > stem.size() + 1 &&
                        name.find_first_not_of("0123456789", stem.size() + 1) == std::string::npos;
  const bool named = file.filename() == path.filename() || (name == stem && extension == ".mtl") ||
                     ((name == stem || numbered) && extension == ".png");
  const auto folder = [](const fs::path& of) {
    std::error_code failed;
    return fs::weakly_canonical(fs::absolute(of).parent_path() / "name", failed);
  };
  return named && folder(file) == folder(path);
}

std::vector<fs::path> replaceable_model_files(const fs::path& path) {
  std::vector<fs::path> files;
  std::error_code failed;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    if (is_file_of_model(path, entry->path())) files.push_back(entry->path());
  }
  return files;
}

}  // namespace holdfast::io
