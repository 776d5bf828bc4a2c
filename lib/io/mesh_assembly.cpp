#include "io/mesh_assembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <functional>
#include <utility>

#include "holdfast/error.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;

std::size_t MeshAssembly::Hash::operator()(const Vertex& vertex) const {
  std::size_t hash = 0;
  for (const float value : {vertex.position.x(), vertex.position.y(), vertex.position.z(),
                            vertex.texture_coordinate.x(), vertex.texture_coordinate.y()}) {
    hash = hash * 1000003 ^ std::hash<float>()(value);
  }
  return hash;
}

std::uint32_t MeshAssembly::index_of(const Vertex& vertex) {
  const auto [entry, is_new] = vertices_.try_emplace(vertex, static_cast<std::uint32_t>(mesh_.positions.size()));
  if (is_new) {
    mesh_.positions.push_back(vertex.position);
    if (with_texture_coordinates_) {
      mesh_.texture_coordinates.push_back(vertex.texture_coordinate);
    }
    if (with_colors_) {
      mesh_.colors.push_back(vertex.color);
    }
  }
  return entry->second;
}

void MeshAssembly::add_triangle(const std::array<Vertex, 3>& corners, std::uint32_t material) {
  const std::array<std::uint32_t, 3> triangle{index_of(corners[0]), index_of(corners[1]), index_of(corners[2])};
  const auto& [a, b, c] = triangle;
  if (a != b && b != c && c != a) {
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_materials.push_back(material);
  }
}

std::uint32_t MeshAssembly::add_material(Material material) {
  mesh_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(mesh_.materials.size() - 1);
}

Mesh MeshAssembly::take() {
  vertices_.clear();
  return std::exchange(mesh_, {});
}

namespace {

int hexadecimal_digit(char digit) {
  const char* digits = "0123456789abcdef";
  const char* found = digit == 0 ? nullptr : std::strchr(digits, std::tolower(static_cast<unsigned char>(digit)));
  return found == nullptr ? -1 : static_cast<int>(found - digits);
}

std::string percent_decoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size() && hexadecimal_digit(text[i + 1]) >= 0 &&
                        hexadecimal_digit(text[i + 2]) >= 0;
    if (escape) {
      decoded += static_cast<char>(hexadecimal_digit(text[i + 1]) * 16 + hexadecimal_digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

}  // namespace

fs::path find_texture(const fs::path& model, const std::string& name) {
  std::string plain = name;
  std::replace(plain.begin(), plain.end(), '\\', '/');
  const fs::path folder = model.parent_path();
  const fs::path as_written = folder / plain;
  for (const fs::path& candidate : {as_written, folder / percent_decoded(plain), folder / fs::path(plain).filename()}) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) {
      return candidate;
    }
  }
  throw Error(ErrorCode::file,
              fmt::format("texture '{}' of model '{}' does not exist: put it there or correct the name in the model",
                          as_written.string(), model.string()));
}

}  // namespace holdfast::io
