#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <unordered_map>
#include <utility>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/text_file.hpp"
#include "io/texture_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

/// Everything that tells two vertices apart; compared bit by bit (assimp's own joining merges vertices up to 1e-5
/// units apart, which is too coarse for small objects in metres).
struct Vertex {
  Eigen::Vector3f position;
  Eigen::Vector2f texture_coordinate;
  std::array<std::uint8_t, 4> color;

  bool operator==(const Vertex&) const = default;
};

struct VertexHash {
  std::size_t operator()(const Vertex& vertex) const {
    std::size_t hash = 0;
    const auto mix = [&hash](float value) { hash = hash * 1000003 ^ std::hash<float>()(value); };
    mix(vertex.position.x());
    mix(vertex.position.y());
    mix(vertex.position.z());
    mix(vertex.texture_coordinate.x());
    mix(vertex.texture_coordinate.y());
    return hash;
  }
};

/// A texture that a material names: its path in the file and the set of texture coordinates it is laid out by.
struct TextureReference {
  std::string path;
  unsigned coordinate_set = 0;
};

TextureReference diffuse_texture(const aiMaterial& material) {
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString path;
    if (material.GetTexture(type, 0, &path) == aiReturn_SUCCESS && path.length > 0) {
      int coordinate_set = 0;
      material.Get(AI_MATKEY_UVWSRC(type, 0), coordinate_set);
      return {path.C_Str(), static_cast<unsigned>(std::max(coordinate_set, 0))};
    }
  }
  return {};
}

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

/// Where a texture named in the model lies: beside the model, whatever slashes and escapes its exporter wrote; an
/// absolute path of the exporting machine falls back on the bare file name.
fs::path find_texture(const fs::path& model, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path folder = model.parent_path();
  const fs::path as_written = folder / name;
  for (const fs::path& candidate : {as_written, folder / percent_decoded(name), folder / fs::path(name).filename()}) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) {
      return candidate;
    }
  }
  throw Error(ErrorCode::file,
              fmt::format("texture '{}' of model '{}' does not exist: put it there or correct the name in the model",
                          as_written.string(), model.string()));
}

Texture embedded_texture(const aiTexture& embedded, const std::string& name) {
  if (embedded.mHeight == 0) {
    return decode_texture(embedded.pcData, embedded.mWidth, name);
  }
  Texture texture{static_cast<int>(embedded.mWidth), static_cast<int>(embedded.mHeight), {}};
  const std::size_t texels = static_cast<std::size_t>(embedded.mWidth) * embedded.mHeight;
  texture.rgba.reserve(texels * 4);
  for (std::size_t i = 0; i < texels; ++i) {
    const aiTexel& texel = embedded.pcData[i];
    texture.rgba.insert(texture.rgba.end(), {texel.r, texel.g, texel.b, texel.a});
  }
  return texture;
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F));
}

/// Gathers assimp's node tree, with its transformations applied, in one Mesh.
class MeshBuilder {
 public:
  MeshBuilder(const aiScene& scene, const fs::path& path, double scale) : scene_(scene), path_(path), scale_(scale) {}

  Mesh build() {
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) {
      with_coordinates_ |= textured(*scene_.mMeshes[i]);
      with_colors_ |= scene_.mMeshes[i]->HasVertexColors(0);
    }
    if (scene_.mRootNode != nullptr) {
      add_node(*scene_.mRootNode, aiMatrix4x4());
    }
    return std::move(mesh_);
  }

 private:
  TextureReference texture_of(const aiMesh& part) const {
    return part.mMaterialIndex < scene_.mNumMaterials ? diffuse_texture(*scene_.mMaterials[part.mMaterialIndex])
                                                      : TextureReference{};
  }

  /// A texture without coordinates to lay it out by covers nothing.
  bool textured(const aiMesh& part) const {
    const TextureReference texture = texture_of(part);
    return !texture.path.empty() && part.HasTextureCoords(texture.coordinate_set);
  }

  std::uint32_t material_of(const aiMesh& part) {
    const bool with_texture = textured(part);
    const auto [entry, is_new] =
        materials_.try_emplace({part.mMaterialIndex, with_texture}, static_cast<std::uint32_t>(mesh_.materials.size()));
    if (is_new) {
      Material material;
      if (part.mMaterialIndex < scene_.mNumMaterials) {
        material.name = scene_.mMaterials[part.mMaterialIndex]->GetName().C_Str();
      }
      if (with_texture) {
        const std::string name = texture_of(part).path;
        const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str());
        material.texture = embedded != nullptr ? embedded_texture(*embedded, path_.string() + ":" + name)
                                               : load_texture(find_texture(path_, name));
      }
      mesh_.materials.push_back(std::move(material));
    }
    return entry->second;
  }

  void add_node(const aiNode& node, const aiMatrix4x4& T_object_parent) {
    const aiMatrix4x4 T_object_node = T_object_parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      add_part(*scene_.mMeshes[node.mMeshes[i]], T_object_node);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
      add_node(*node.mChildren[i], T_object_node);
    }
  }

  void add_part(const aiMesh& part, const aiMatrix4x4& T_object_part) {
    if (!part.HasFaces()) {
      return;
    }
    const unsigned coordinate_set = texture_of(part).coordinate_set;
    const bool mirrored = T_object_part.Determinant() < 0;
    const std::uint32_t material = material_of(part);
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) {
        continue;
      }
      std::array<std::uint32_t, 3> triangle{};
      for (unsigned k = 0; k < 3; ++k) {
        triangle[k] = add_vertex(part, face.mIndices[k], coordinate_set, T_object_part);
      }
      if (mirrored) {
        std::swap(triangle[1], triangle[2]);
      }
      const bool degenerate = triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
      if (!degenerate) {
        mesh_.triangles.push_back(triangle);
        mesh_.triangle_materials.push_back(material);
      }
    }
  }

  std::uint32_t add_vertex(const aiMesh& part, unsigned index, unsigned coordinate_set,
                           const aiMatrix4x4& T_object_part) {
    const aiVector3D position = T_object_part * part.mVertices[index];
    Vertex vertex{
        (Eigen::Vector3d(position.x, position.y, position.z) * scale_).cast<float>(), Eigen::Vector2f::Zero(), {}};
    if (with_coordinates_ && part.HasTextureCoords(coordinate_set)) {
      const aiVector3D& coordinate = part.mTextureCoords[coordinate_set][index];
      vertex.texture_coordinate = {coordinate.x, coordinate.y};
    }
    if (part.HasVertexColors(0)) {
      const aiColor4D& color = part.mColors[0][index];
      vertex.color = {to_byte(color.r), to_byte(color.g), to_byte(color.b), to_byte(color.a)};
    }
    const auto [entry, is_new] = vertices_.try_emplace(vertex, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(vertex.position);
      if (with_coordinates_) {
        mesh_.texture_coordinates.push_back(vertex.texture_coordinate);
      }
      if (with_colors_) {
        mesh_.colors.push_back(vertex.color);
      }
    }
    return entry->second;
  }

  const aiScene& scene_;
  const fs::path& path_;
  double scale_;
  bool with_coordinates_ = false;
  bool with_colors_ = false;  // parts without colours get alpha 0 then: surface that gives no constraints
  Mesh mesh_;
  std::map<std::pair<unsigned, bool>, std::uint32_t> materials_;  // assimp's index, textured -> ours
  std::unordered_map<Vertex, std::uint32_t, VertexHash> vertices_;
};

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

Mesh load_model(const fs::path& path, double scale) {
  if (!(std::isfinite(scale) && scale > 0)) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("the model's scale is {}: give a positive number, 0.001 for millimetres", scale));
  }
  require_file(path, "model");
  Assimp::Importer importer;
  if (!path.has_extension() || !importer.IsExtensionSupported(path.extension().string())) {
    throw Error(ErrorCode::file,
                fmt::format("model '{}' is of a format that is not supported: use OBJ, PLY or glTF", path.string()));
  }
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (scene == nullptr) {
    throw Error(ErrorCode::file, fmt::format("model '{}' cannot be read ({}): is the file complete and readable?",
                                             path.string(), one_line(importer.GetErrorString())));
  }
  Mesh mesh = MeshBuilder(*scene, path, scale).build();
  try {
    mesh.validate();
  } catch (const Error& error) {
    std::string reason = error.what();
    if (reason.starts_with("model: ")) {
      reason.erase(0, std::strlen("model: "));
    }
    throw Error(ErrorCode::model, fmt::format("model '{}': {}", path.string(), reason));
  }
  return mesh;
}

}  // namespace holdfast::io
