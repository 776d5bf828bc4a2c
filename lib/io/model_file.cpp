#include <assimp/DefaultIOSystem.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/gltf_file.hpp"
#include "io/mesh_assembly.hpp"
#include "io/named_file.hpp"
#include "io/numbers.hpp"
#include "io/obj_file.hpp"
#include "io/off_file.hpp"
#include "io/ply_file.hpp"
#include "io/stl_file.hpp"
#include "io/text_file.hpp"
#include "io/texture_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNodes = 1'000'000;

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
      return {path.C_Str(), static_cast<unsigned>(std::clamp(coordinate_set, 0, AI_MAX_NUMBER_OF_TEXTURECOORDS - 1))};
    }
  }
  return {};
}

Texture embedded_texture(const aiTexture& embedded, const std::string& name) {
  constexpr unsigned most = 1 << 14;
  if (embedded.mHeight > most || (embedded.mHeight > 0 && embedded.mWidth > most)) {
    throw Error(ErrorCode::file,
                fmt::format("image '{}' is {}x{}, too large", name, embedded.mWidth, embedded.mHeight));
  }
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

/// assimp's node tree, with its transformations applied, as one Mesh.
class SceneReader {
 public:
  SceneReader(const aiScene& scene, const fs::path& path, double scale)
      : scene_(scene), path_(path), scale_(scale), assembly_(any_part_with_coordinates(), any_part_colored()) {}

  Mesh read() {
    require_whole();
    if (scene_.mRootNode != nullptr) {
      add_nodes(*scene_.mRootNode);
    }
    return assembly_.take();
  }

 private:
  /// An importer is not to be trusted with a damaged file: all that is used below is there.
  void require_whole() const {
    const auto fail = [this](const std::string& reason) {
      throw Error(ErrorCode::file,
                  fmt::format("model '{}' cannot be read ({}): is the file complete?", path_.string(), reason));
    };
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) {
      const aiMesh* part = scene_.mMeshes[i];
      if (part == nullptr || (part->mNumFaces > 0 && (part->mFaces == nullptr || part->mVertices == nullptr))) {
        fail(fmt::format("its mesh {} has no vertices", i));
      }
      for (unsigned f = 0; f < part->mNumFaces; ++f) {
        const aiFace& face = part->mFaces[f];
        for (unsigned k = 0; k < face.mNumIndices; ++k) {
          if (face.mIndices[k] >= part->mNumVertices) {
            fail(fmt::format("a face refers to vertex {}, but there are {}", face.mIndices[k], part->mNumVertices));
          }
        }
      }
    }
    std::vector<const aiNode*> open;
    if (scene_.mRootNode != nullptr) open.push_back(scene_.mRootNode);
    for (std::size_t seen = 0; !open.empty(); ++seen) {
      const aiNode* node = open.back();
      open.pop_back();
      if (node == nullptr || seen > kMostNodes) fail("its tree of parts is damaged");
      for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        if (node->mMeshes[i] >= scene_.mNumMeshes) fail(fmt::format("it refers to mesh {}", node->mMeshes[i]));
      }
      open.insert(open.end(), node->mChildren, node->mChildren + node->mNumChildren);
    }
  }

  TextureReference texture_of(const aiMesh& part) const {
    return part.mMaterialIndex < scene_.mNumMaterials ? diffuse_texture(*scene_.mMaterials[part.mMaterialIndex])
                                                      : TextureReference{};
  }

  /// A texture without coordinates to lay it out by covers nothing.
  bool textured(const aiMesh& part) const {
    const TextureReference texture = texture_of(part);
    return !texture.path.empty() && part.HasTextureCoords(texture.coordinate_set);
  }

  bool any_part_with_coordinates() const {
    return std::any_of(scene_.mMeshes, scene_.mMeshes + scene_.mNumMeshes,
                       [this](const aiMesh* part) { return part->HasTextureCoords(texture_of(*part).coordinate_set); });
  }

  bool any_part_colored() const {
    return std::any_of(scene_.mMeshes, scene_.mMeshes + scene_.mNumMeshes,
                       [](const aiMesh* part) { return part->HasVertexColors(0); });
  }

  std::uint32_t material_of(const aiMesh& part) {
    const bool with_texture = textured(part);
    const std::pair key{part.mMaterialIndex, with_texture};
    if (const auto known = materials_.find(key); known != materials_.end()) {
      return known->second;
    }
    std::string name;
    if (part.mMaterialIndex < scene_.mNumMaterials) {
      name = scene_.mMaterials[part.mMaterialIndex]->GetName().C_Str();
    }
    if (!with_texture) return materials_[key] = assembly_.add_material({name, {}});
    const std::string picture = texture_of(part).path;
    const aiTexture* embedded = scene_.GetEmbeddedTexture(picture.c_str());
    if (embedded == nullptr) return materials_[key] = assembly_.add_picture(find_texture(path_, picture), name);
    return materials_[key] = assembly_.add_picture(
               ":" + picture, name, {}, [&] { return embedded_texture(*embedded, path_.string() + ":" + picture); });
  }

  void add_nodes(const aiNode& root) {
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{&root, root.mTransformation}};  // may be deep
    while (!open.empty()) {
      const auto [node, T_object_node] = open.back();
      open.pop_back();
      for (unsigned i = 0; i < node->mNumMeshes; ++i) add_part(*scene_.mMeshes[node->mMeshes[i]], T_object_node);
      for (unsigned i = 0; i < node->mNumChildren; ++i) {
        open.push_back({node->mChildren[i], T_object_node * node->mChildren[i]->mTransformation});
      }
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
        continue;  // points and lines
      }
      std::array<Vertex, 3> corners;
      for (unsigned k = 0; k < 3; ++k) {
        corners[k] = vertex_of(part, face.mIndices[k], coordinate_set, T_object_part);
      }
      if (mirrored) {
        std::swap(corners[1], corners[2]);
      }
      assembly_.add_triangle(corners, material);
    }
  }

  Vertex vertex_of(const aiMesh& part, unsigned index, unsigned coordinate_set,
                   const aiMatrix4x4& T_object_part) const {
    const aiVector3D position = T_object_part * part.mVertices[index];
    Vertex vertex;
    vertex.position = (Eigen::Vector3d(position.x, position.y, position.z) * scale_).cast<float>();
    if (part.HasTextureCoords(coordinate_set)) {
      const aiVector3D& coordinate = part.mTextureCoords[coordinate_set][index];
      vertex.texture_coordinate = {coordinate.x, coordinate.y};
    }
    if (part.HasVertexColors(0)) {
      const aiColor4D& color = part.mColors[0][index];
      vertex.color = {to_byte(color.r), to_byte(color.g), to_byte(color.b), to_byte(color.a)};
    }
    return vertex;
  }

  const aiScene& scene_;
  const fs::path& path_;
  double scale_;
  MeshAssembly assembly_;
  std::map<std::pair<unsigned, bool>, std::uint32_t> materials_;  // assimp's index, textured -> ours
};

std::string lower_extension(const fs::path& path) { return lower(path.extension().string()); }

/// Notes what an importer opens.
class NotedFiles : public Assimp::IOSystem {
 public:
  explicit NotedFiles(std::vector<fs::path>& opened) : opened_(opened) {}

  bool Exists(const char* file) const override { return files_.Exists(file); }
  char getOsSeparator() const override { return files_.getOsSeparator(); }
  void Close(Assimp::IOStream* stream) override { files_.Close(stream); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    Assimp::IOStream* stream = files_.Open(file, mode);
    if (stream != nullptr && std::find(opened_.begin(), opened_.end(), file) == opened_.end()) opened_.push_back(file);
    return stream;
  }

 private:
  Assimp::DefaultIOSystem files_;  // final in assimp 6
  std::vector<fs::path>& opened_;
};

/// Throws Error(file) for a format of CAD programs, which describe surfaces.
void refuse_cad(const fs::path& path) {
  constexpr std::string_view extensions[] = {".step",       ".stp",    ".iges", ".igs", ".brep", ".fcstd",
                                             ".sldprt",     ".sldasm", ".ipt",  ".iam", ".prt",  ".catpart",
                                             ".catproduct", ".x_t",    ".x_b",  ".f3d", ".3dm",  ".dwg"};
  if (std::find(std::begin(extensions), std::end(extensions), lower_extension(path)) == std::end(extensions)) return;
  throw Error(ErrorCode::file, fmt::format("model '{}' is a CAD file, of surfaces instead of triangles: export it as "
                                           "STL or OBJ from the CAD program",
                                           path.string()));
}

Mesh load_with_assimp(const fs::path& path, double scale) {
  Assimp::Importer importer;
  if (!path.has_extension() || !importer.IsExtensionSupported(path.extension().string())) {
    refuse_cad(path);
    throw Error(
        ErrorCode::file,
        fmt::format("model '{}' is of a format that is not supported: use OBJ, PLY, STL, OFF or glTF", path.string()));
  }
  const aiScene* scene = nullptr;
  std::string reason = "it is damaged";
  try {
    scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
    if (scene == nullptr) reason = importer.GetErrorString();
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (scene == nullptr) {
    read_binary_file(path, "model");  // says so if it is something else in the model's place
    refuse_cad(path);                 // assimp takes STEP for IFC, which is written alike
    throw Error(ErrorCode::file, fmt::format("model '{}' cannot be read ({}): is the file complete and readable?",
                                             path.string(), reason));
  }
  return SceneReader(*scene, path, scale).read();
}

Mesh load_by_format(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") return load_obj(path, scale, remarks);
  if (extension == ".ply") return load_ply(path, scale, remarks);
  if (extension == ".off") return load_off(path, scale, remarks);
  if (extension == ".stl") return load_stl(path, scale);
  if (extension == ".gltf" || extension == ".glb") return load_gltf(path, scale, remarks);
  return load_with_assimp(path, scale);
}

/// What an importer opens, and the textures that the materials it found name.
std::vector<fs::path> files_by_assimp(const fs::path& path) {
  std::vector<fs::path> files{path};
  Assimp::Importer importer;
  importer.SetIOHandler(new NotedFiles(files));  // which the importer owns from now on
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  for (unsigned i = 0; scene != nullptr && i < scene->mNumMaterials; ++i) {
    const std::string name = diffuse_texture(*scene->mMaterials[i]).path;
    if (name.empty() || scene->GetEmbeddedTexture(name.c_str()) != nullptr) continue;
    if (const auto file = named_file(name, {path.parent_path()})) files.push_back(*file);
  }
  return files;
}

std::vector<fs::path> named_files(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") return obj_files(path);
  if (extension == ".gltf" || extension == ".glb") return gltf_files(path);
  if (extension == ".off" || extension == ".stl") return {};
  if (extension != ".ply") return files_by_assimp(path);
  std::vector<fs::path> files;
  for (const std::string& name : ply_textures(path)) {
    if (const auto file = named_file(name, {path.parent_path()})) files.push_back(*file);
  }
  return files;
}

/// A texel or a vertex colour is opaque enough to be known.
bool any_look_known(const Mesh& mesh) {
  for (const Material& material : mesh.materials) {
    const std::vector<std::uint8_t>& rgba = material.texture.rgba;
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
      if (rgba[i] >= kKnownAlpha) return true;
    }
  }
  return std::any_of(mesh.colors.begin(), mesh.colors.end(), [](const auto& color) { return color[3] >= kKnownAlpha; });
}

}  // namespace

Mesh load_model(const fs::path& path, double scale, std::vector<std::string>* remarks) {
  if (!(std::isfinite(scale) && scale > 0)) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("the model's scale is {}: give a positive number, 0.001 for millimetres", scale));
  }
  require_file(path, "model");
  std::vector<std::string> ignored;
  std::optional<Mesh> mesh;
  try {
    mesh = load_by_format(path, scale, remarks != nullptr ? *remarks : ignored);
    mesh->validate();
    if (remarks != nullptr && mesh->has_appearance() && !any_look_known(*mesh)) {
      remarks->push_back(
          fmt::format("model '{}' has a texture or colours, but none of it is known, since it is transparent all over "
                      "(alpha below {} of 255): save it opaque",
                      path.string(), kKnownAlpha));
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::model) throw;
    std::string reason = error.what();
    if (reason.find(path.string()) != std::string::npos) throw;
    if (reason.starts_with("model: ")) {
      reason.erase(0, std::strlen("model: "));
    }
    throw Error(ErrorCode::model, fmt::format("model '{}': {}", path.string(), reason));
  }
  return *std::move(mesh);
}

std::vector<fs::path> model_files(const fs::path& path) {
  std::vector<fs::path> files{path};
  try {
    for (fs::path& file : named_files(path)) files.push_back(std::move(file));
  } catch (const Error&) {
    // No model, or a damaged one.
  }
  std::sort(files.begin() + 1, files.end());
  files.erase(std::unique(files.begin() + 1, files.end()), files.end());
  return files;
}

}  // namespace holdfast::io
