#include "io/gltf_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/gltf_document.hpp"
#include "io/gltf_look.hpp"
#include "io/mesh_assembly.hpp"
#include "io/model_fault.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// A primitive of a mesh that the scene shows.
struct Part {
  const json* primitive = nullptr;
  Eigen::Affine3d T_object_part = Eigen::Affine3d::Identity();
  std::size_t material = kNone;
  std::vector<double> weights;  ///< of its morph targets
};

class GltfReader {
 public:
  GltfReader(const fs::path& path, double scale, std::vector<std::string>& remarks)
      : document_(path), scale_(scale), remarks_(remarks) {}

  Mesh read() {
    require_extensions();
    collect_parts();
    bool textured = false, vertex_colors = false;
    std::set<std::array<std::uint8_t, 4>> looks;
    for (const Part& part : parts_) {
      const bool with_texture = is_textured(part);
      if (!with_texture) tell_why_plain(part);
      textured = textured || with_texture;
      vertex_colors = vertex_colors || (!with_texture && attribute(part, "COLOR_0"));
      if (!with_texture) looks.insert(look(part.material).color);
    }
    // One colour all over shows nothing that the outline does not; beside a texture it may be what exporters write for
    // surface that they know nothing of.
    colored_ = vertex_colors || looks.size() > 1;
    assembly_.emplace(textured, colored_);
    for (const Part& part : parts_) add(part);
    return assembly_->take();
  }

 private:
  void require_extensions() {
    for (const json& extension : document_.list(document_.root(), "extensionsRequired")) {
      const std::string name = extension.is_string() ? extension.get<std::string>() : "";
      constexpr std::string_view known[] = {"KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual",
                                            "EXT_texture_webp"};
      const bool supported =
          std::find(std::begin(known), std::end(known), name) != std::end(known) || name.starts_with("KHR_materials_");
      if (!supported) {
        throw Error(ErrorCode::model, fmt::format("model '{}' needs the glTF extension '{}', which is not supported: "
                                                  "export it without",
                                                  document_.path().string(), name));
      }
    }
  }

  /// Every primitive of the scene, without recursion: files may nest nodes as deep as they like.
  void collect_parts() {
    std::vector<std::pair<std::size_t, Eigen::Affine3d>> open;
    for (const std::size_t root : roots()) open.push_back({root, Eigen::Affine3d::Identity()});
    std::set<std::size_t> seen;
    while (!open.empty()) {
      const auto [index, T_object_parent] = open.back();
      open.pop_back();
      if (!seen.insert(index).second)
        document_.fail(fmt::format("its node {} stands in the scene twice", index), kExportAnew);
      const json& node = document_.item("nodes", index);
      const Eigen::Affine3d T_object_node = T_object_parent * transform(node);
      if (const auto mesh = document_.index(node, "mesh")) collect_primitives(*mesh, node, T_object_node);
      for (const std::size_t child : indices(node, "children")) open.push_back({child, T_object_node});
    }
  }

  void collect_primitives(std::size_t mesh, const json& node, const Eigen::Affine3d& T_object_node) {
    const bool skinned = node.contains("skin");
    if (skinned) remark("its skin is not supported, the mesh is taken unbent");
    if (document_.part(node, "extensions").contains("EXT_mesh_gpu_instancing")) {
      remark("its instances (EXT_mesh_gpu_instancing) are not supported, the mesh is taken once: export them as nodes");
    }
    // Joints place a skinned mesh, and the transform of its node does not count.
    const Eigen::Affine3d T_object_part = skinned ? Eigen::Affine3d::Identity() : T_object_node;
    const json& described = document_.item("meshes", mesh);
    const std::vector<double> weights = weights_of(node.contains("weights") ? node : described);
    for (const json& primitive : document_.list(described, "primitives")) {
      if (document_.part(primitive, "extensions").contains("KHR_draco_mesh_compression")) {
        document_.fail("it is compressed with KHR_draco_mesh_compression, which is not supported", "export it without");
      }
      parts_.push_back({&primitive, T_object_part, document_.index(primitive, "material").value_or(kNone), weights});
    }
  }

  std::vector<double> weights_of(const json& owner) const {
    const std::size_t count = document_.list(owner, "weights").size();
    return document_.numbers(owner, "weights", std::vector<double>(count));
  }

  std::vector<std::size_t> indices(const json& object, const char* key) const {
    std::vector<std::size_t> result;
    for (const json& value : document_.list(object, key)) {
      if (!value.is_number_unsigned()) document_.fail(fmt::format("its '{}' is no list of indices", key), kExportAnew);
      result.push_back(value.get<std::size_t>());
    }
    return result;
  }

  /// The scene's nodes; without a scene all that are no children.
  std::vector<std::size_t> roots() const {
    if (!document_.list(document_.root(), "scenes").empty()) {
      return indices(document_.item("scenes", document_.index(document_.root(), "scene").value_or(0)), "nodes");
    }
    const json& nodes = document_.list(document_.root(), "nodes");
    std::set<std::size_t> children;
    for (const json& node : nodes) {
      for (const std::size_t child : indices(node, "children")) children.insert(child);
    }
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!children.contains(i)) result.push_back(i);
    }
    return result;
  }

  Eigen::Affine3d transform(const json& node) const {
    Eigen::Affine3d T = Eigen::Affine3d::Identity();
    if (node.contains("matrix")) {
      const std::vector<double> matrix = document_.numbers(node, "matrix", std::vector<double>(16));
      T.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix.data());  // by columns, as Eigen's
      return T;
    }
    const std::vector<double> t = document_.numbers(node, "translation", {0, 0, 0});
    const std::vector<double> q = document_.numbers(node, "rotation", {0, 0, 0, 1});
    const std::vector<double> s = document_.numbers(node, "scale", {1, 1, 1});
    T.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix() *
                 Eigen::Vector3d(s[0], s[1], s[2]).asDiagonal();
    T.translation() << t[0], t[1], t[2];
    return T;
  }

  std::optional<std::size_t> attribute(const Part& part, const std::string& name) const {
    return document_.index(document_.part(*part.primitive, "attributes"), name.c_str());
  }

  const GltfLook& look(std::size_t material) {
    const auto [known, is_new] = looks_.try_emplace(material);
    if (is_new && material != kNone) known->second = gltf_look(document_, material);
    return known->second;
  }

  std::string coordinate_name(const Part& part) {
    return fmt::format("TEXCOORD_{}", look(part.material).coordinate_set);
  }

  /// A texture without coordinates to lay it out by covers nothing.
  bool is_textured(const Part& part) {
    return look(part.material).image.has_value() && attribute(part, coordinate_name(part)).has_value();
  }

  /// A material whose picture is not seen.
  void tell_why_plain(const Part& part) {
    const GltfLook& seen = look(part.material);
    if (seen.image) {
      remark(fmt::format("a part of material '{}' has no {}, its texture is not seen on it", seen.name,
                         coordinate_name(part)));
    } else if (seen.emits_image) {
      remark(
          fmt::format("the texture of material '{}' is what it emits (emissiveTexture), which is not supported: make "
                      "it the base colour",
                      seen.name));
    } else if (seen.lacks_image) {
      remark(fmt::format("the texture of material '{}' names no picture, it is not seen", seen.name));
    }
  }

  std::uint32_t material_of(const Part& part, bool textured) {
    const auto [known, is_new] = made_.try_emplace({part.material, textured}, 0);
    if (is_new) {
      const GltfLook& seen = look(part.material);
      known->second = textured ? assembly_->add_picture(seen.picture(), seen.name, seen.wrapping,
                                                        [&] { return gltf_texture(document_, seen); })
                               : assembly_->add_material({seen.name, {}});
    }
    return known->second;
  }

  void add(const Part& part) {
    const auto mode = document_.index(*part.primitive, "mode").value_or(4);
    const auto position = attribute(part, "POSITION");
    if (mode < 4 || mode > 6 || !position) return;  // points and lines
    const bool textured = is_textured(part);
    const std::vector<Vertex> vertices = vertices_of(part, *position, textured);
    const std::uint32_t material = material_of(part, textured);
    std::vector<std::uint32_t> indices;
    if (const auto accessor = document_.index(*part.primitive, "indices")) {
      indices = document_.whole_values(*accessor);
    } else {
      indices.resize(vertices.size());
      for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
    }
    const bool mirrored = part.T_object_part.linear().determinant() < 0;
    const std::size_t step = mode == 4 ? 3 : 1;
    for (std::size_t i = 0; i + 2 < indices.size(); i += step) {
      std::array<std::uint32_t, 3> corners{indices[mode == 6 ? 0 : i], indices[i + 1], indices[i + 2]};
      if ((mode == 5 && i % 2 != 0) != mirrored) std::swap(corners[1], corners[2]);
      std::array<Vertex, 3> triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        if (corners[k] >= vertices.size()) {
          document_.fail(fmt::format("a face refers to vertex {}, but there are {}", corners[k], vertices.size()),
                         kExportAnew);
        }
        triangle[k] = vertices[corners[k]];
      }
      assembly_->add_triangle(triangle, material);
    }
  }

  /// Moves positions as far as the file's weights of morph targets say.
  void morph(const Part& part, GltfValues& positions) {
    const json& targets = document_.list(*part.primitive, "targets");
    for (std::size_t i = 0; i < std::min(targets.size(), part.weights.size()); ++i) {
      const auto accessor = document_.index(targets[i], "POSITION");
      if (!accessor || part.weights[i] == 0) continue;
      const GltfValues moved = document_.values(*accessor);
      if (moved.values.size() != positions.values.size()) {
        document_.fail("a morph target is not of its primitive's length", kExportAnew);
      }
      for (std::size_t k = 0; k < moved.values.size(); ++k) {
        positions.values[k] += static_cast<float>(part.weights[i] * moved.values[k]);
      }
    }
  }

  std::vector<Vertex> vertices_of(const Part& part, std::size_t position_accessor, bool textured) {
    const GltfLook& seen = look(part.material);
    GltfValues positions = document_.values(position_accessor);
    morph(part, positions);
    std::vector<Vertex> vertices(positions.count());
    GltfValues coordinates, colors;
    if (textured) coordinates = document_.values(*attribute(part, coordinate_name(part)));
    if (const auto accessor = attribute(part, "COLOR_0")) colors = document_.values(*accessor);
    const bool lacking = positions.components != 3 ||
                         (textured && (coordinates.count() < vertices.size() || coordinates.components != 2)) ||
                         (colors.components != 0 && (colors.count() < vertices.size() || colors.components < 3));
    if (lacking)
      document_.fail("a primitive's attributes are not of one length, or of another kind than they must be",
                     kExportAnew);
    if (textured &&
        std::any_of(colors.values.begin(), colors.values.end(), [](float value) { return value < 0.99F; })) {
      remark("colours of vertices beside a texture are not supported, the texture is taken alone");
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Eigen::Vector3d p = Eigen::Map<const Eigen::Vector3f>(&positions.values[3 * i]).cast<double>();
      vertices[i].position = ((part.T_object_part * p) * scale_).cast<float>();
      if (textured)
        vertices[i].texture_coordinate = seen.place(coordinates.values[2 * i], coordinates.values[2 * i + 1]);
      if (colored_ && !textured) {
        vertices[i].color =
            seen.color_of(colors.components == 0 ? nullptr : &colors.values[colors.components * i], colors.components);
      }
    }
    return vertices;
  }

  void remark(const std::string& what) {
    const std::string line = fmt::format("model '{}': {}", document_.path().string(), what);
    if (std::find(remarks_.begin(), remarks_.end(), line) == remarks_.end()) remarks_.push_back(line);
  }

  GltfDocument document_;
  double scale_;
  std::vector<std::string>& remarks_;
  std::vector<Part> parts_;
  std::map<std::size_t, GltfLook> looks_;                       ///< by material
  std::map<std::pair<std::size_t, bool>, std::uint32_t> made_;  ///< material, textured -> the mesh's
  bool colored_ = false;
  std::optional<MeshAssembly> assembly_;
};

}  // namespace

Mesh load_gltf(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  return GltfReader(path, scale, remarks).read();
}

std::vector<fs::path> gltf_files(const fs::path& path) { return GltfDocument(path).named_files(); }

}  // namespace holdfast::io
