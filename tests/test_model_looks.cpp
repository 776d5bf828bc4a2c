// What a model looks like, as its format says: how textures are laid out, colours, and a line for each thing that is
// missing or not supported.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::base64;
using holdfast::test::TemporaryFolder;

namespace {

using Color = std::array<std::uint8_t, 4>;

constexpr Color kRed{255, 0, 0, 255}, kGreen{0, 255, 0, 255}, kBlue{0, 0, 255, 255}, kGrey{90, 91, 92, 255};

/// Red and green over blue and grey.
std::string four_colors() {
  cv::Mat bgr(2, 2, CV_8UC3);
  bgr.at<cv::Vec3b>(0, 0) = {0, 0, 255};
  bgr.at<cv::Vec3b>(0, 1) = {0, 255, 0};
  bgr.at<cv::Vec3b>(1, 0) = {255, 0, 0};
  bgr.at<cv::Vec3b>(1, 1) = {92, 91, 90};
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", bgr, bytes);
  return {bytes.begin(), bytes.end()};
}

std::string half_transparent() {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", cv::Mat(2, 2, CV_8UC4, cv::Scalar(30, 20, 10, 128)), bytes);
  return {bytes.begin(), bytes.end()};
}

/// The colour at a place of a triangle, by the texel that lies there where the texture is repeated.
Color seen(const Mesh& mesh, std::size_t triangle, double a, double b) {
  const auto& corners = mesh.triangles[triangle];
  const Texture& texture = mesh.materials[mesh.triangle_materials[triangle]].texture;
  const Eigen::Vector2f uv = mesh.texture_coordinates[corners[0]] * static_cast<float>(1 - a - b) +
                             mesh.texture_coordinates[corners[1]] * static_cast<float>(a) +
                             mesh.texture_coordinates[corners[2]] * static_cast<float>(b);
  const auto texel = [](double place, int size) {
    return std::min(static_cast<int>((place - std::floor(place)) * size), size - 1);
  };
  const int x = texel(uv.x(), texture.width), y = texel(1 - uv.y(), texture.height);
  const auto* p = &texture.rgba[static_cast<std::size_t>(4 * (y * texture.width + x))];
  return {p[0], p[1], p[2], p[3]};
}

/// An OBJ of one triangle whose texture coordinates go from 0 to 1, and what map_Kd says before the picture's name.
struct ObjFiles {
  TemporaryFolder folder;

  Mesh load(const std::string& map, std::vector<std::string>* remarks = nullptr) const {
    folder.write("a.png", four_colors());
    folder.write("m.mtl", "newmtl m\nmap_Kd " + map + "\n");
    folder.write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
    return io::load_model(folder / "m.obj", 1, remarks);
  }
};

std::vector<std::string> remarks_of(const std::filesystem::path& path) {
  std::vector<std::string> remarks;
  io::load_model(path, 1, &remarks);
  return remarks;
}

bool any_says(const std::vector<std::string>& remarks, const std::string& words) {
  return std::any_of(remarks.begin(), remarks.end(),
                     [&](const std::string& remark) { return remark.find(words) != std::string::npos; });
}

/// A glTF of one triangle (coordinates 0 to 1, v downwards) with this material, and more beside it.
std::string gltf(const std::string& material, const std::string& png, const std::string& sampler = "{}",
                 const std::string& more = "") {
  std::string data;
  for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F}) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    data.append(raw, sizeof(value));
  }
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],"materials":[)" +
         material + R"(],"textures":[{"source":0,"sampler":0}],"samplers":[)" + sampler +
         R"(],"images":[{"uri":"data:image/png;base64,)" + base64(png) +
         R"("}],"buffers":[{"byteLength":60,"uri":"data:;base64,)" + base64(data) +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}])" +
         more + "}";
}

const std::string kTextured = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";

}  // namespace

TEST_CASE("OBJ: options of map_Kd lay the texture out, and names keep their blanks") {
  const ObjFiles files;
  Mesh mesh = files.load("a.png");
  CHECK(seen(mesh, 0, 0.1, 0.1) == kBlue);
  CHECK(seen(mesh, 0, 0.6, 0.1) == kGrey);
  mesh = files.load("-s 2 2 1 a.png");
  CHECK(seen(mesh, 0, 0.3, 0.1) == kGrey);
  CHECK(seen(mesh, 0, 0.6, 0.1) == kBlue);  // repeated
  mesh = files.load("-o 0.5 0 0 a.png");
  CHECK(seen(mesh, 0, 0.1, 0.1) == kGrey);
  mesh = files.load("-blendu on -s 1 2 1 -o 0 0.5 0 a.png");
  CHECK(seen(mesh, 0, 0.1, 0.1) == kRed);
  CHECK(seen(mesh, 0, 0.1, 0.35) == kBlue);
  mesh = files.load("-clamp on -s 2 1 1 a.png");
  CHECK(seen(mesh, 0, 0.1, 0.1) == kBlue);
  CHECK(seen(mesh, 0, 0.4, 0.1) == kGrey);
  CHECK(seen(mesh, 0, 0.7, 0.1) == kGrey);  // the border goes on
  std::vector<std::string> remarks;
  CHECK(seen(files.load("-mm 0.1 2 a.png", &remarks), 0, 0.1, 0.1) == kBlue);
  CHECK(any_says(remarks, "-mm"));
  CHECK(seen(files.load("a.png  \t"), 0, 0.1, 0.1) == kBlue);
  files.folder.write("two words.png", four_colors());
  CHECK(seen(files.load("two words.png "), 0, 0.1, 0.1) == kBlue);
}

TEST_CASE("OBJ: materials in a folder of their own, under names that the MTL lacks, or not there") {
  const TemporaryFolder folder;
  folder.write("sub/a.png", four_colors());
  folder.write("sub/a.mtl", "newmtl m\nmap_Kd a.png\n");
  const std::string body = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
  for (const char* library : {"sub/a.mtl", "sub\\a.mtl", "  sub/a.mtl  ", "none.mtl sub/a.mtl"}) {
    CAPTURE(library);
    const Mesh mesh = io::load_model(
        folder.write("m.obj", "mtllib " + std::string(library) + "\n" + body + "usemtl m\nf 1/1 2/2 3/3\n"));
    CHECK(mesh.has_appearance());
    CHECK(seen(mesh, 0, 0.1, 0.1) == kBlue);
  }
  CHECK(any_says(remarks_of(folder.write("m.obj", "mtllib sub/a.mtl\n" + body + "usemtl other\nf 1/1 2/2 3/3\n")),
                 "'other'"));
  CHECK(any_says(remarks_of(folder.write("m.obj", "mtllib gone.mtl\n" + body + "usemtl m\nf 1/1 2/2 3/3\n")),
                 "gone.mtl"));
  CHECK(remarks_of(folder.write("m.obj", "mtllib sub/a.mtl\n" + body + "usemtl m\nf 1/1 2/2 3/3\n")).empty());
}

TEST_CASE("OBJ: a plain look where the file seems to have one is told") {
  const TemporaryFolder folder;
  folder.write("a.png", four_colors());
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n", face = "f 1/1 2/2 3/3\n";
  const auto remarks = [&](const std::string& material, const std::string& body) {
    folder.write("m.mtl", "newmtl m\n" + material + "\n");
    return remarks_of(folder.write("m.obj", body));
  };
  CHECK(any_says(remarks("", corners + "usemtl m\n" + face), "'m', but names no material file"));
  CHECK(any_says(remarks("map_Ka a.png", "mtllib m.mtl\n" + corners + "usemtl m\n" + face), "map_Ka"));
  CHECK(any_says(remarks("map_Ke a.png", "mtllib m.mtl\n" + corners + "usemtl m\n" + face), "map_Ke"));
  CHECK(any_says(remarks("map_Kd a.png", "mtllib m.mtl\n" + corners + "usemtl m\nf 1 2 3\n"), "texture coordinates"));
  CHECK(remarks("map_Ka a.png\nmap_Kd a.png", "mtllib m.mtl\n" + corners + "usemtl m\n" + face).empty());
  CHECK(remarks("", corners + face).empty());
  CHECK(any_says(remarks("map_Kd a.png", "mtllib m.mtl\n" + corners + face), "'usemtl m'"));
  CHECK(remarks("map_Kd a.png", "mtllib m.mtl\n" + corners + "f 1 2 3\nusemtl m\n" + face).empty());
}

TEST_CASE("OBJ: names in quotes, keywords in capitals") {
  const TemporaryFolder folder;
  folder.write("a b.png", four_colors());
  folder.write("the m.mtl", "NEWMTL m\nMAP_KD \"a b.png\"\n");
  const Mesh mesh = io::load_model(folder.write(
      "m.obj", "MTLLIB \"the m.mtl\"\nV 0 0 0\nV 1 0 0\nV 0 1 0\nVT 0 0\nVT 1 0\nVT 0 1\nUSEMTL m\nF 1/1 2/2 3/3\n"));
  CHECK(seen(mesh, 0, 0.1, 0.1) == kBlue);
}

TEST_CASE("OBJ: colours of vertices as shares of 1, or of 255") {
  const TemporaryFolder folder;
  const auto colors = [&](const char* first, const char* second) {
    const Mesh mesh = io::load_model(
        folder.write("m.obj", std::string("v 0 0 0 ") + first + "\nv 1 0 0 " + second + "\nv 0 1 0 0 0 0\nf 1 2 3\n"));
    REQUIRE(mesh.colors.size() == 3);
    return std::pair{mesh.colors[mesh.triangles[0][0]], mesh.colors[mesh.triangles[0][1]]};
  };
  CHECK(colors("1 0 0", "0 0.5 1") == std::pair{kRed, Color{0, 128, 255, 255}});
  CHECK(colors("1 0 0", "0 0.5 1.02") == std::pair{kRed, Color{0, 128, 255, 255}});
  CHECK(colors("1 0 0", "0 128 255") == std::pair{Color{1, 0, 0, 255}, Color{0, 128, 255, 255}});
  // Seven numbers: a weight of 1 before the colour, or alpha after it.
  CHECK(colors("1.0 1 0 0", "1.0 0 0.5 1") == std::pair{kRed, Color{0, 128, 255, 255}});
  CHECK(colors("1 0 0 1", "0 0.5 1 1") == std::pair{kRed, Color{0, 128, 255, 255}});
  CHECK(colors("1 0 0 1", "1 0.5 1 1") == std::pair{kRed, Color{255, 128, 255, 255}});
  CHECK(colors("1 0 0 .5", "1 0.5 1 .5") == std::pair{kRed, Color{255, 128, 255, 255}});
}

TEST_CASE("OBJ: colours of materials are seen where there are several, and one alone is none") {
  const TemporaryFolder folder;
  folder.write("m.mtl", "newmtl r\nKd 1 0 0\nnewmtl g\nKd 0 1 0\n");
  const std::string body = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  const Mesh two = io::load_model(folder.write("two.obj", body + "usemtl r\nf 1 2 3\nusemtl g\nf 2 4 3\n"));
  REQUIRE(two.has_appearance());
  CHECK(two.colors[two.triangles[0][0]] == kRed);
  CHECK(two.colors[two.triangles[1][0]] == kGreen);
  CHECK_FALSE(io::load_model(folder.write("one.obj", body + "usemtl r\nf 1 2 3\nf 2 4 3\n")).has_appearance());
}

TEST_CASE("OBJ: byte order marks, numbers without a leading zero, continued lines, line ends of every system") {
  const TemporaryFolder folder;
  for (const char* text :
       {"\xef\xbb\xbfv 0 0 0\nv .5 0 0\nv 0 +.5 0\nf 1 2 3\n", "v 0 0 0\r\nv 5e-1 0 0\r\nv 0 .5 0\r\nf 1 2 3\r\n",
        "v 0 0 0\rv .5 0 0\rv 0 .5 0\rf 1 2 3\r", "v 0 0 \\\n0\nv .5 0 0\nv 0 .5 0\nf 1 2 \\\n3",
        "# c\no x\ng y\ns off\nv 0 0 0 # first\nv .5 0 0\nv 0 .5 0\nf -3 -2 -1\n"}) {
    CAPTURE(text);
    const Mesh mesh = io::load_model(folder.write("m.obj", text));
    CHECK(mesh.positions[1] == Eigen::Vector3f(0.5F, 0, 0));
    CHECK(mesh.triangles.size() == 1);
  }
}

TEST_CASE("Polygons are cut into triangles that cover them, also where a corner turns inwards") {
  const TemporaryFolder folder;
  // An L of area 3, its corners either way round.
  const std::string corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  for (const char* face : {"f 1 2 3 4 5 6\n", "f 4 5 6 1 2 3\n", "f 6 5 4 3 2 1\n"}) {
    const Mesh mesh = io::load_model(folder.write("m.obj", corners + face));
    REQUIRE(mesh.triangles.size() == 4);
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      area += 0.5 * (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).norm();
    }
    CHECK(area == doctest::Approx(3));
  }
}

TEST_CASE("PLY: coordinates of faces without a texture, under other names, in strips, colours of faces") {
  const TemporaryFolder folder;
  const auto ply = [](const std::string& comment, const std::string& list) {
    return "ply\nformat ascii 1.0\n" + comment +
           "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list "
           "uchar "
           "int vertex_indices\nproperty list uchar float " +
           list + "\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n";
  };
  folder.write("a.png", four_colors());
  for (const char* list : {"texcoord", "t", "uv", "st", "tex_coords", "texture_coordinates", "TexCoord"}) {
    CAPTURE(list);
    const Mesh mesh = io::load_model(folder.write("m.ply", ply("comment TextureFile a.png \n", list)));
    CHECK(seen(mesh, 0, 0.1, 0.1) == kBlue);
    CHECK(io::load_model(folder.write("l.ply", ply("COMMENT texturefile a.png\n", list))).has_appearance());
    CHECK(any_says(remarks_of(folder.write("n.ply", ply("", list))), "comment TextureFile"));
    CHECK_FALSE(io::load_model(folder / "n.ply").has_appearance());
  }
  CHECK(any_says(remarks_of(folder.write("o.ply", ply("comment TextureFile a.png\n", "other"))), "no coordinates"));
  const Mesh colored = io::load_model(folder.write(
      "c.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
      "face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty "
      "uchar blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 255 0 0\n3 1 3 2 0 255 0\n"));
  CHECK(colored.colors[colored.triangles[0][1]] == kRed);
  CHECK(colored.colors[colored.triangles[1][0]] == kGreen);
  const Mesh strip = io::load_model(folder.write(
      "s.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 0 1 2 3 -1\n"));
  REQUIRE(strip.triangles.size() == 2);
  for (const auto& [a, b, c] : strip.triangles) {
    CHECK((strip.positions[b] - strip.positions[a]).cross(strip.positions[c] - strip.positions[a]).z() > 0);
  }
}

TEST_CASE("PLY: numbers, names and line ends of other programs") {
  const TemporaryFolder folder;
  const auto ply = [](const std::string& type, const std::string& values, const std::string& end = "\n") {
    std::string text =
        "ply|format ascii 1.0|obj_info x|element vertex 3|property float X|property float Y|property float Z";
    for (const char* name : {"Red", "Green", "Blue"}) text += "|property " + type + " " + name;
    text += "|element face 1|property list uchar int Vertex_Indices|end_header|";
    for (const char* place : {"0 -0 0", "+1 0 0", "0 .1e1 0"}) text += std::string(place) + " " + values + "|";
    text += "3 0 1 2|";
    for (std::size_t at = 0; (at = text.find('|', at)) != text.npos; at += end.size()) text.replace(at, 1, end);
    return text;
  };
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const Mesh mesh = io::load_model(folder.write("m.ply", ply("uchar", "0 128 255", end)));
    REQUIRE(mesh.colors.size() == 3);
    CHECK(mesh.colors[0] == Color{0, 128, 255, 255});
    CHECK(mesh.positions[1] == Eigen::Vector3f(1, 0, 0));
  }
  CHECK(io::load_model(folder.write("m.ply", ply("ushort", "0 32896 65535"))).colors[0] == Color{0, 128, 255, 255});
  CHECK(io::load_model(folder.write("m.ply", ply("float", "0 0.5 1"))).colors[0] == Color{0, 128, 255, 255});
}

TEST_CASE("glTF: alpha counts only where the material says so") {
  const TemporaryFolder folder;
  CHECK(seen(io::load_model(folder.write("o.gltf", gltf(kTextured, half_transparent()))), 0, 0.2, 0.2)[3] == 255);
  const std::string blend = R"({"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  CHECK(seen(io::load_model(folder.write("b.gltf", gltf(blend, half_transparent()))), 0, 0.2, 0.2)[3] == 128);
  for (const auto& [cutoff, alpha] : {std::pair{"", 255}, {R"("alphaCutoff":0.6,)", 0}}) {
    const std::string mask =
        std::string(R"({"alphaMode":"MASK",)") + cutoff + R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    CHECK(seen(io::load_model(folder.write("m.gltf", gltf(mask, half_transparent()))), 0, 0.2, 0.2)[3] == alpha);
  }
}

TEST_CASE("glTF: KHR_texture_transform and wrapping") {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& transform, const std::string& sampler = "{}") {
    return io::load_model(folder.write(
        "m.gltf",
        gltf(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":)" +
                 transform + "}}}}",
             four_colors(), sampler, R"(,"extensionsRequired":["KHR_texture_transform"])")));
  };
  // v goes down in the file: coordinate (0, 0) is the upper left corner, red.
  CHECK(seen(load("{}"), 0, 0.1, 0.1) == kRed);
  CHECK(seen(load("{}"), 0, 0.6, 0.1) == kGreen);
  CHECK(seen(load("{}"), 0, 0.1, 0.6) == kBlue);
  CHECK(seen(load(R"({"offset":[0.5,0]})"), 0, 0.1, 0.1) == kGreen);
  CHECK(seen(load(R"({"offset":[0,0.5]})"), 0, 0.1, 0.1) == kBlue);
  CHECK(seen(load(R"({"scale":[2,1]})"), 0, 0.3, 0.1) == kGreen);
  // The specification's example: the lower left quarter of the picture alone, turned by 90 degrees.
  const Mesh quarter = load(R"({"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]})");
  for (const auto& [a, b] : {std::pair{0.05, 0.05}, {0.9, 0.05}, {0.05, 0.9}, {0.4, 0.4}}) {
    CHECK(seen(quarter, 0, a, b) == kBlue);
  }
  // Turned alone: what lay to the right of the corner lies above it.
  CHECK(seen(load(R"({"offset":[0,1],"rotation":1.57079632679})"), 0, 0.6, 0.1) == kRed);
  CHECK(seen(load(R"({"offset":[0,1],"rotation":1.57079632679})"), 0, 0.1, 0.6) == kGrey);

  const std::string twice = R"({"scale":[2,1]})";
  CHECK(seen(load(twice, R"({"wrapS":10497})"), 0, 0.6, 0.1) == kRed);
  CHECK(seen(load(twice, R"({"wrapS":33648})"), 0, 0.6, 0.1) == kGreen);  // mirrored
  CHECK(seen(load(twice, R"({"wrapS":33648})"), 0, 0.85, 0.1) == kRed);
  CHECK(seen(load(twice, R"({"wrapS":33071})"), 0, 0.85, 0.1) == kGreen);  // clamped
  CHECK(seen(load(R"({"scale":[1,2]})", R"({"wrapT":33071})"), 0, 0.1, 0.85) == kBlue);
}

TEST_CASE("glTF: base colours, alone and over a texture") {
  const TemporaryFolder folder;
  const std::string half = R"({"pbrMetallicRoughness":{"baseColorFactor":[0.5,0,1,1],"baseColorTexture":{"index":0}}})";
  const Mesh tinted = io::load_model(folder.write("t.gltf", gltf(half, four_colors())));
  const Color red = seen(tinted, 0, 0.1, 0.1), blue = seen(tinted, 0, 0.1, 0.6);
  CHECK(red[0] == 188);  // half the light of full red, as sRGB encodes it
  CHECK(red[1] == 0);
  CHECK(blue == kBlue);
  const std::string colors = R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]}},
                                {"pbrMetallicRoughness":{"baseColorFactor":[0,0,1,1]}})";
  std::string two = gltf(colors, four_colors());
  const std::string first = R"("material":0})";
  two.insert(two.find(first) + first.size(), R"(,{"attributes":{"POSITION":0},"material":1})");
  const Mesh mesh = io::load_model(folder.write("two.gltf", two));
  REQUIRE(mesh.has_appearance());
  CHECK(mesh.colors[mesh.triangles[0][0]] == kRed);
  CHECK(mesh.colors[mesh.triangles[1][0]] == kBlue);
  std::string three = gltf(kTextured + "," + colors, four_colors());  // beside a texture
  three.insert(three.find(first) + first.size(),
               R"(,{"attributes":{"POSITION":0},"material":1},{"attributes":{"POSITION":0},"material":2})");
  const Mesh mixed = io::load_model(folder.write("three.gltf", three));
  REQUIRE(mixed.colors.size() == mixed.positions.size());
  CHECK(seen(mixed, 0, 0.1, 0.1) == kRed);
  CHECK(mixed.colors[mixed.triangles[1][0]] == kRed);
  CHECK(mixed.colors[mixed.triangles[2][0]] == kBlue);
}

TEST_CASE("glTF: a plain look where the file seems to have one is told") {
  const TemporaryFolder folder;
  const auto remarks = [&](const std::string& material) {
    return remarks_of(folder.write("m.gltf", gltf(material, four_colors())));
  };
  CHECK(any_says(remarks(R"({"emissiveTexture":{"index":0}})"), "emissiveTexture"));
  CHECK(any_says(remarks(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}})"), "TEXCOORD_1"));
  CHECK(any_says(remarks(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":
                            {"KHR_texture_transform":{"texCoord":2}}}}})"),
                 "TEXCOORD_2"));
  CHECK(remarks(R"({"emissiveTexture":{"index":0},"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})").empty());
}

TEST_CASE("glTF: what is not supported is named") {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& text) { return io::load_model(folder.write("m.gltf", text)); };
  for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu"}) {
    CHECK_ERROR(load(gltf(kTextured, four_colors(), "{}", std::string(R"(,"extensionsRequired":[")") + name + "\"]")),
                ErrorCode::model, "m.gltf", name, "not supported");
  }
  std::string basis = gltf(kTextured, four_colors());
  const std::string plain = R"({"source":0,"sampler":0})";
  basis.replace(basis.find(plain), plain.size(), R"({"extensions":{"KHR_texture_basisu":{"source":0}}})");
  CHECK_ERROR(load(basis), ErrorCode::model, "m.gltf", "KHR_texture_basisu", "not supported");
  // WebP is decoded.
  std::vector<std::uint8_t> webp;
  cv::imencode(".webp", cv::Mat(4, 4, CV_8UC3, cv::Scalar(0, 0, 255)), webp, {cv::IMWRITE_WEBP_QUALITY, 101});
  std::string text = gltf(kTextured, {webp.begin(), webp.end()});
  text.replace(text.find(plain), plain.size(), R"({"extensions":{"EXT_texture_webp":{"source":0}}})");
  CHECK(seen(load(text), 0, 0.2, 0.2) == kRed);
}
