// What each model format's features come to: read as the format says, read with a warning, or refused. The table of
// docs/reference/model_formats.md is made of these; HOLDFAST_WRITE_REFERENCE=1 writes it again.
#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "support/files.hpp"

using namespace holdfast;
using holdfast::test::base64;
using holdfast::test::read_file;
using holdfast::test::TemporaryFolder;

namespace {

enum class Outcome { read, warned, refused };

/// Of what is read: triangles, and how it looks.
struct Seen {
  std::size_t triangles = 0;
  bool textured = false, colored = false;
  bool operator==(const Seen&) const = default;
};

struct Feature {
  std::string format, name;
  std::string file;                          ///< the model's name
  std::map<std::string, std::string> files;  ///< it, and what lies beside it
  Outcome outcome = Outcome::read;
  Seen seen;
};

std::string picture(const char* extension) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 100, 200)), bytes);
  return {bytes.begin(), bytes.end()};
}

template <typename Value>
std::string raw(std::initializer_list<Value> values) {
  std::string bytes(values.size() * sizeof(Value), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

constexpr Seen kPlain{1, false, false}, kTextured{1, true, false}, kColored{1, false, true};

std::vector<Feature> obj_features() {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n", face = "f 1/1 2/2 3/3\n";
  const auto textured = [&](const std::string& map) {
    return std::map<std::string, std::string>{{"m.obj", "mtllib m.mtl\n" + corners + "usemtl m\n" + face},
                                              {"m.mtl", "newmtl m\n" + map + "\n"},
                                              {"a.png", picture(".png")}};
  };
  const auto plain = [](const std::string& text) { return std::map<std::string, std::string>{{"m.obj", text}}; };
  return {
      {"OBJ", "triangles, polygons", "m.obj", plain("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"), {}, {2}},
      {"OBJ", "indices from the end", "m.obj", plain(corners + "f -3 -2 -1\n"), {}, kPlain},
      {"OBJ",
       "colours of vertices (v x y z r g b)",
       "m.obj",
       plain("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n"),
       {},
       kColored},
      {"OBJ", "map_Kd", "m.obj", textured("map_Kd a.png"), {}, kTextured},
      {"OBJ", "map_Kd -s, -o, -clamp", "m.obj", textured("map_Kd -s 2 1 1 -o 0.5 0 0 -clamp on a.png"), {}, kTextured},
      {"OBJ", "map_Kd -mm", "m.obj", textured("map_Kd -mm 0.1 2 a.png"), Outcome::warned, kTextured},
      {"OBJ", "map_Ka or map_Ke without map_Kd", "m.obj", textured("map_Ka a.png"), Outcome::warned, kPlain},
      {"OBJ", "map_Kd whose picture is not there", "m.obj", textured("map_Kd b.png"), Outcome::refused, {}},
      {"OBJ", "Kd of one material alone", "m.obj", textured("Kd 1 0 0"), {}, kPlain},
      {"OBJ",
       "Kd of several materials",
       "m.obj",
       {{"m.obj", "mtllib m.mtl\n" + corners + "v 1 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 2 4 3\n"},
        {"m.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n"}},
       {},
       {2, false, true}},
      {"OBJ",
       "usemtl of a name that the MTL lacks",
       "m.obj",
       {{"m.obj", "mtllib m.mtl\n" + corners + "usemtl x\n" + face}, {"m.mtl", "newmtl m\n"}},
       Outcome::warned,
       kPlain},
      {"OBJ", "usemtl without mtllib", "m.obj", plain(corners + "usemtl m\n" + face), Outcome::warned, kPlain},
      {"OBJ",
       "map_Kd without usemtl",
       "m.obj",
       {{"m.obj", "mtllib m.mtl\n" + corners + face}, {"m.mtl", "newmtl m\nmap_Kd a.png\n"}},
       Outcome::warned,
       kPlain},
      {"OBJ",
       "map_Kd on faces without texture coordinates",
       "m.obj",
       {{"m.obj", "mtllib m.mtl\n" + corners + "usemtl m\nf 1 2 3\n"},
        {"m.mtl", "newmtl m\nmap_Kd a.png\n"},
        {"a.png", picture(".png")}},
       Outcome::warned,
       kPlain},
      {"OBJ", "mtllib that is not there", "m.obj", plain("mtllib x.mtl\n" + corners + face), Outcome::warned, kPlain},
      {"OBJ",
       "lines, points, groups, smoothing",
       "m.obj",
       plain(corners + "g a\ns 1\np 1\nl 1 2\n" + face),
       {},
       kPlain},
  };
}

std::vector<Feature> ply_features() {
  const auto ply = [](const std::string& head, const std::string& vertex, const std::string& face,
                      const std::string& data) {
    return std::map<std::string, std::string>{
        {"m.ply", "ply\nformat ascii 1.0\n" + head +
                      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + vertex +
                      "element face 1\nproperty list uchar int vertex_indices\n" + face + "end_header\n" + data},
        {"a.png", picture(".png")}};
  };
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string binary_head =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n" + binary_head +
                             raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}) + raw<std::uint8_t>({3}) + raw<int>({0, 1, 2});
  const std::string named = "comment TextureFile a.png\n", lists = "property list uchar float texcoord\n",
                    coordinates = "3 0 1 2 6 0 0 1 0 0 1\n";
  return {
      {"PLY", "text", "m.ply", ply("", "", "", points + "3 0 1 2\n"), {}, kPlain},
      {"PLY", "binary", "m.ply", {{"m.ply", binary}}, {}, kPlain},
      {"PLY", "cut short", "m.ply", {{"m.ply", binary.substr(0, binary.size() - 5)}}, Outcome::refused, {}},
      {"PLY",
       "colours of vertices",
       "m.ply",
       ply("", "property uchar red\nproperty uchar green\nproperty uchar blue\n", "",
           "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n"),
       {},
       kColored},
      {"PLY",
       "colours of faces",
       "m.ply",
       ply("", "", "property uchar red\nproperty uchar green\nproperty uchar blue\n", points + "3 0 1 2 255 0 0\n"),
       {},
       kColored},
      {"PLY",
       "coordinates of vertices (s, t) with TextureFile",
       "m.ply",
       ply(named, "property float s\nproperty float t\n", "", "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"),
       {},
       kTextured},
      {"PLY",
       "coordinates of faces (texcoord) with TextureFile",
       "m.ply",
       ply(named, "", lists, points + coordinates),
       {},
       kTextured},
      {"PLY", "TextureFile without coordinates", "m.ply", ply(named, "", "", points + "3 0 1 2\n"), Outcome::warned,
       kPlain},
      {"PLY", "coordinates without TextureFile", "m.ply", ply("", "", lists, points + coordinates), Outcome::warned,
       kPlain},
  };
}

std::vector<Feature> other_features() {
  const auto off = [](const std::string& text) { return std::map<std::string, std::string>{{"m.off", text}}; };
  std::string stl(80, ' ');
  stl += raw<std::uint32_t>({1}) + raw<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0});
  return {
      {"OFF", "text", "m.off", off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), {}, kPlain},
      {"OFF",
       "colours of vertices (COFF)",
       "m.off",
       off("COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n"),
       {},
       kColored},
      {"OFF", "colours of vertices under OFF instead of COFF", "m.off",
       off("OFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n"), Outcome::warned, kPlain},
      {"OFF",
       "normals (NOFF)",
       "m.off",
       off("NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"),
       {},
       kPlain},
      {"OFF", "binary", "m.off", off("OFF BINARY\n" + std::string(12, '\0')), Outcome::refused, {}},
      {"STL",
       "text",
       "m.stl",
       {{"m.stl",
         "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
         "0\nendloop\nendfacet\nendsolid "
         "s\n"}},
       {},
       kPlain},
      {"STL", "binary", "m.stl", {{"m.stl", stl + std::string(2, '\0')}}, {}, kPlain},
      {"STL", "binary, cut short", "m.stl", {{"m.stl", stl}}, Outcome::refused, {}},
      {"STL", "binary, colours of facets", "m.stl", {{"m.stl", stl + raw<std::uint16_t>({0x8000 | 31})}}, {}, kColored},
  };
}

/// A glTF of one triangle.
std::map<std::string, std::string> gltf(const std::string& material, const std::string& image,
                                        const std::string& texture = R"({"source":0,"sampler":0})",
                                        const std::string& more = "", const std::string& sampler = "{}") {
  const std::string data = raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1});
  return {{"m.gltf",
           R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],"materials":[)" +
               material + R"(],"textures":[)" + texture + R"(],"samplers":[)" + sampler +
               R"(],"images":[{"uri":"data:image/png;base64,)" + base64(image) +
               R"("}],"buffers":[{"byteLength":60,"uri":"data:;base64,)" + base64(data) +
               R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}])" +
               more + "}"}};
}

std::vector<Feature> gltf_features() {
  const std::string textured = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const std::string turned = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{
    "KHR_texture_transform":{"offset":[0.5,0]}}}}})";
  const std::string plain = R"({"source":0,"sampler":0})";
  const auto required = [](const std::string& name) { return R"(,"extensionsRequired":[")" + name + "\"]"; };
  std::vector<Feature> features = {
      {"glTF 2.0", "baseColorTexture: PNG", "m.gltf", gltf(textured, picture(".png")), {}, kTextured},
      {"glTF 2.0", "baseColorTexture: JPEG", "m.gltf", gltf(textured, picture(".jpg")), {}, kTextured},
      {"glTF 2.0",
       "EXT_texture_webp",
       "m.gltf",
       gltf(textured, picture(".webp"), R"({"extensions":{"EXT_texture_webp":{"source":0}}})"),
       {},
       kTextured},
      {"glTF 2.0",
       "KHR_texture_transform",
       "m.gltf",
       gltf(turned, picture(".png"), plain, required("KHR_texture_transform")),
       {},
       kTextured},
      {"glTF 2.0",
       "wrapping: mirrored, clamped",
       "m.gltf",
       gltf(textured, picture(".png"), plain, "", R"({"wrapS":33648,"wrapT":33071})"),
       {},
       kTextured},
  };
  features.push_back(
      {"glTF 2.0", "a texture whose coordinates are not there", "m.gltf",
       gltf(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}})", picture(".png")),
       Outcome::warned, kPlain});
  features.push_back({"glTF 2.0", "emissiveTexture alone", "m.gltf",
                      gltf(R"({"emissiveTexture":{"index":0}})", picture(".png")), Outcome::warned, kPlain});
  const auto with_node = [&](const std::string& what) {
    std::map<std::string, std::string> files = gltf(textured, picture(".png"));
    std::string& text = files["m.gltf"];
    const std::string node = R"({"mesh":0})";
    text.replace(text.find(node), node.size(), R"({"mesh":0,)" + what + "}");
    return files;
  };
  features.push_back(
      {"glTF 2.0", "a texture without a picture", "m.gltf", gltf(textured, "", "{}"), Outcome::warned, kPlain});
  features.push_back({"glTF 2.0", "a skin", "m.gltf", with_node(R"("skin":0)"), Outcome::warned, kTextured});
  features.push_back({"glTF 2.0", "EXT_mesh_gpu_instancing, not required", "m.gltf",
                      with_node(R"("extensions":{"EXT_mesh_gpu_instancing":{}})"), Outcome::warned, kTextured});
  for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu"}) {
    features.push_back(
        {"glTF 2.0", name, "m.gltf", gltf(textured, picture(".png"), plain, required(name)), Outcome::refused, {}});
  }
  return features;
}

std::vector<Feature> all_features() {
  std::vector<Feature> all = obj_features();
  for (const auto& more : {ply_features(), other_features(), gltf_features()}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

std::string words(const Feature& feature) {
  if (feature.outcome == Outcome::refused) return "refused, in a line that says why";
  std::string text = feature.outcome == Outcome::warned ? "a warning; " : "";
  return text + (feature.seen.textured  ? "read, with its texture"
                 : feature.seen.colored ? "read, with its colours"
                                        : "read, plain");
}

std::string table() {
  std::string text = "| format | what the file has | what Holdfast makes of it |\n|---|---|---|\n";
  for (const Feature& feature : all_features()) {
    text += "| " + feature.format + " | " + feature.name + " | " + words(feature) + " |\n";
  }
  return text;
}

}  // namespace

TEST_CASE("Each feature of a model format comes to what the reference says") {
  for (const Feature& feature : all_features()) {
    CAPTURE(feature.format);
    CAPTURE(feature.name);
    const TemporaryFolder folder;
    for (const auto& [name, text] : feature.files) folder.write(name, text);
    std::vector<std::string> remarks;
    Mesh mesh;
    const test::CaughtError error = test::error_of([&] { mesh = io::load_model(folder / feature.file, 1, &remarks); });
    CAPTURE(error.message);
    CHECK(error.thrown == (feature.outcome == Outcome::refused));
    if (error.thrown) continue;
    CHECK(remarks.empty() == (feature.outcome == Outcome::read));
    const bool textured = !mesh.materials.empty() && !mesh.materials[0].texture.empty();
    CHECK(Seen{mesh.triangles.size(), textured, !mesh.colors.empty()} == feature.seen);
  }
}

TEST_CASE("The reference's table is these") {
  const std::filesystem::path path = std::filesystem::path(HOLDFAST_SOURCE_DIR) / "docs/reference/model_formats.md";
  const std::string begin = "<!-- table -->\n";
  std::string text = read_file(path);
  const std::size_t at = text.find(begin);
  REQUIRE(at != text.npos);
  const std::string wanted = text.substr(0, at + begin.size()) + table();
  if (std::getenv("HOLDFAST_WRITE_REFERENCE") != nullptr) {
    std::ofstream(path) << wanted;
  } else {
    CHECK(text == wanted);
  }
}
