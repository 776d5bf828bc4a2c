// Pictures of models: one copy of each, whatever name and however many materials it is named by, and what of it is
// known.
#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "show/model_sheet.hpp"
#include "support/files.hpp"

using namespace holdfast;
using holdfast::test::base64;
using holdfast::test::TemporaryFolder;

namespace {

const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n";

std::string picture(const cv::Scalar& bgra = {10, 100, 200, 255}) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", cv::Mat(4, 4, CV_8UC4, bgra), bytes);
  return {bytes.begin(), bytes.end()};
}

/// A glTF whose triangles, all the same, have these materials.
std::string gltf(const std::vector<std::string>& materials, const std::string& images, const std::string& textures) {
  std::string data, primitives, listed;
  for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F}) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    data.append(raw, sizeof(value));
  }
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::string comma = i > 0 ? "," : "";
    primitives += comma + R"({"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":)" + std::to_string(i) + "}";
    listed += comma + R"({"pbrMetallicRoughness":)" + materials[i] + "}";
  }
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" + primitives +
         R"(]}],"materials":[)" + listed + R"(],"textures":[)" + textures + R"(],"images":[)" + images +
         R"(],"buffers":[{"byteLength":60,"uri":"data:;base64,)" + base64(data) +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]})";
}

}  // namespace

TEST_CASE("OBJ: materials of one picture share it, laid out by each, but for how it is wrapped") {
  const TemporaryFolder folder;
  folder.write("a.png", picture());
  folder.write("m.mtl",
               "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd -o 0.25 0 0 ./a.png\nnewmtl c\nmap_Kd -clamp on a.png\n");
  const Mesh mesh = io::load_model(folder.write(
      "m.obj",
      "mtllib m.mtl\n" + kCorners + "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 4/3\nusemtl c\nf 1/1 3/2 4/3\n"));
  REQUIRE(mesh.materials.size() == 2);
  CHECK(mesh.materials[0].name == "a");
  CHECK(mesh.triangle_materials == std::vector<std::uint32_t>{0, 0, 1});
  CHECK(mesh.texture_coordinates[mesh.triangles[0][0]].x() == 0.0F);
  CHECK(mesh.texture_coordinates[mesh.triangles[1][0]].x() == 0.25F);
}

TEST_CASE("OBJ: parts beside a texture keep their colours where they are several") {
  const TemporaryFolder folder;
  folder.write("a.png", picture());
  folder.write("m.mtl", "newmtl r\nKd 1 0 0\nnewmtl g\nKd 0 1 0\nnewmtl t\nKd 1 1 1\nmap_Kd a.png\n");
  const std::string printed = "mtllib m.mtl\n" + kCorners + "usemtl t\nf 1/1 2/2 3/3\nusemtl r\nf 2 4 3\n";
  const Mesh mesh = io::load_model(folder.write("two.obj", printed + "usemtl g\nf 1 2 4\n"));
  REQUIRE(mesh.colors.size() == mesh.positions.size());
  CHECK(mesh.colors[mesh.triangles[1][0]] == std::array<std::uint8_t, 4>{255, 0, 0, 255});
  CHECK(mesh.colors[mesh.triangles[2][0]] == std::array<std::uint8_t, 4>{0, 255, 0, 255});
  CHECK_FALSE(mesh.materials[mesh.triangle_materials[0]].texture.empty());
  CHECK(mesh.materials[mesh.triangle_materials[1]].texture.empty());
  CHECK(io::load_model(folder.write("one.obj", printed)).colors.empty());
  io::save_model(folder / "saved.obj", mesh);
  CHECK(io::load_model(folder / "saved.obj").colors == mesh.colors);
}

TEST_CASE("OBJ: files are found whatever capitals their names have, and comments after names are left out") {
  const TemporaryFolder folder;
  folder.write("Skins/Tex.PNG", picture());
  folder.write("face.PNG", picture());
  folder.write("Skins/tex #2.png", picture({0, 0, 0, 255}));
  const std::string face = "f 1/1 2/2 3/3\n";
  const auto red = [&](const std::string& library, const std::string& map, const std::string& use = "m",
                       const std::string& define = "m") {
    folder.write("My model.mtl", "newmtl " + define + "\nmap_Kd " + map + "\n");
    const Mesh mesh =
        io::load_model(folder.write("m.obj", "mtllib " + library + "\n" + kCorners + "usemtl " + use + "\n" + face));
    return mesh.has_appearance() ? mesh.materials[0].texture.rgba[0] : -1;
  };
  const std::string library = "My model.mtl", map = "Skins/Tex.PNG";
  CHECK(red("my Model.MTL", map) == 200);
  CHECK(red(library, "skins\\tex.png") == 200);
  CHECK(red(library, "C:\\scans\\FACE.png") == 200);
  CHECK(red(library + " # made by hand", map + " # the skin") == 200);
  CHECK(red(library, map, "m # first") == 200);
  CHECK(red(library, map, "m", "m # first") == 200);
  CHECK(red(library, "Skins/tex #2.png") == 0);
  CHECK(red(library, map, "m #1", "m #1") == 200);
  CHECK(red(library, map, "m #2", "m #1") == -1);
}

TEST_CASE("glTF: materials of one picture share it where they make the same of it") {
  const TemporaryFolder folder;
  const std::string first = R"({"baseColorTexture":{"index":0}})", second = R"({"baseColorTexture":{"index":1}})",
                    tinted = R"({"baseColorFactor":[1,0.5,1,1],"baseColorTexture":{"index":0}})",
                    image = R"({"uri":"data:image/png;base64,)" + base64(picture()) + "\"}";
  const Mesh mesh = io::load_model(folder.write(
      "m.gltf", gltf({first, first, tinted, second}, image + "," + image, R"({"source":0},{"source":1})")));
  CHECK(mesh.triangle_materials == std::vector<std::uint32_t>{0, 0, 1, 0});
  REQUIRE(mesh.materials.size() == 2);
  CHECK(mesh.materials[0].texture.rgba[1] == 100);
  CHECK(mesh.materials[1].texture.rgba[1] < 100);
}

TEST_CASE("PLY: a picture named twice is there once") {
  const TemporaryFolder folder;
  folder.write("a.png", picture());
  const Mesh mesh = io::load_model(folder.write(
      "m.ply",
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile a.png\nelement vertex 4\nproperty float "
      "x\nproperty float y\nproperty float z\nelement face 3\nproperty list uchar int vertex_indices\nproperty list "
      "uchar float texcoord\nproperty int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 6 0 0 1 0 0 1 "
      "0\n3 0 1 3 6 0 0 1 0 0 1 1\n3 0 2 3 0 0\n"));
  REQUIRE(mesh.materials.size() == 2);
  CHECK(mesh.triangle_materials == std::vector<std::uint32_t>{0, 0, 1});
  CHECK_FALSE(mesh.materials[0].texture.empty());
  CHECK(mesh.materials[1].texture.empty());
}

TEST_CASE("A look that is transparent all over is told, and shown as not known") {
  const TemporaryFolder folder;
  const auto check = [](const std::filesystem::path& path, bool known) {
    std::vector<std::string> remarks;
    const Mesh mesh = io::load_model(path, 1, &remarks);
    CHECK(remarks.empty() == known);
    if (!known && !remarks.empty()) CHECK(remarks[0].find("transparent all over") != std::string::npos);
    CHECK(app::model_text(mesh).find(known ? " 100 % of the surface" : " 0 % of the surface") != std::string::npos);
  };
  folder.write("m.mtl", "newmtl m\nmap_Kd a.png\n");
  for (const int alpha : {0, 128, 249, 250, 255}) {
    CAPTURE(alpha);
    const bool known = alpha >= 250;
    folder.write("a.png", picture(cv::Scalar(10, 100, 200, alpha)));
    check(folder.write("m.obj", "mtllib m.mtl\n" + kCorners + "usemtl m\nf 1/1 2/2 3/3\n"), known);
    const std::string color = " 1 2 3 " + std::to_string(alpha) + "\n";
    check(
        folder.write("m.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
                     "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement "
                     "face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0" +
                         color + "1 0 0" + color + "0 1 0" + color + "3 0 1 2\n"),
        known);
  }
}

TEST_CASE("A closed model whose faces look inwards is doubted, as a mirrored one's do") {
  Mesh corner;
  corner.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  CHECK_FALSE(app::model_doubt(corner));
  Mesh mirrored = corner;
  for (Eigen::Vector3f& position : mirrored.positions) position.x() *= -1;
  CHECK(app::model_doubt(mirrored).value_or("").find("mirrored") != std::string::npos);
  mirrored.triangles.pop_back();  // open: no side is the inner one
  CHECK_FALSE(app::model_doubt(mirrored));
}
