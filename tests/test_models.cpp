// Reading and writing models and their textures: every format's own ways, and one line for what cannot be used.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
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

/// Red, green over blue (never seen), grey (half seen): every corner differs.
Texture small_texture() { return {2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0, 90, 91, 92, 128}}; }

std::string png_of(const Texture& texture) {
  cv::Mat bgra(texture.height, texture.width, CV_8UC4);
  for (int i = 0; i < texture.width * texture.height; ++i) {
    const auto* p = &texture.rgba[static_cast<std::size_t>(4 * i)];
    bgra.at<cv::Vec4b>(i / texture.width, i % texture.width) = {p[2], p[1], p[0], p[3]};
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", bgra, bytes);
  return {bytes.begin(), bytes.end()};
}

/// What a corner of a triangle shows, for comparing meshes whose vertices stand in another order.
struct Corner {
  Eigen::Vector3f position;
  Eigen::Vector2f uv;
  std::array<std::uint8_t, 4> color;
};

std::vector<Corner> corners_of(const Mesh& mesh) {
  std::vector<Corner> corners;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) {
      corners.push_back({mesh.positions[index],
                         mesh.texture_coordinates.empty() ? Eigen::Vector2f::Zero() : mesh.texture_coordinates[index],
                         mesh.colors.empty() ? std::array<std::uint8_t, 4>{} : mesh.colors[index]});
    }
  }
  return corners;
}

const Texture& texture_of_triangle(const Mesh& mesh, std::size_t triangle) {
  return mesh.materials[mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[triangle]].texture;
}

const std::string kTriangleObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

}  // namespace

TEST_CASE("OBJ: polygons, materials and their textures, v upwards, alpha kept") {
  const TemporaryFolder folder;
  folder.write("a.png", png_of(small_texture()));
  folder.write("textures/b c.png", png_of({1, 1, {1, 2, 3, 255}}));
  folder.write("m.mtl", "newmtl first\nKd 1 1 1\nmap_Kd a.png\nnewmtl second\nmap_Kd textures\\b c.png\n");
  // A quad, a triangle, and the quad's first triangle again with vertices listed anew.
  folder.write("m.obj",
               "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
               "usemtl first\nf 1/1 2/2 3/3 4/4\nusemtl second\nf 1/1 2/2 5/3\n");
  const Mesh mesh = io::load_model(folder / "m.obj");
  REQUIRE(mesh.triangles.size() == 3);
  CHECK(mesh.positions.size() == 5);  // the triangles share the corners that have the same texture coordinate
  REQUIRE(mesh.materials.size() == 2);
  CHECK(mesh.materials[0].name == "first");
  CHECK(mesh.materials[0].texture.rgba == small_texture().rgba);
  CHECK(mesh.materials[1].texture.rgba == std::vector<std::uint8_t>{1, 2, 3, 255});
  CHECK(texture_of_triangle(mesh, 2).width == 1);
  // The corner at (0, 1) is drawn at v = 1: the top row of the picture, red at its left.
  bool found = false;
  for (const Corner& corner : corners_of(mesh)) {
    if (corner.position == Eigen::Vector3f(0, 1, 0)) {
      found = true;
      CHECK(corner.uv == Eigen::Vector2f(0, 1));
    }
  }
  CHECK(found);
  CHECK(mesh.has_appearance());
}

TEST_CASE("The model's scale turns its unit into metres") {
  const TemporaryFolder folder;
  folder.write("m.obj", "v 0 0 0\nv 150 0 0\nv 0 100 60\nf 1 2 3\n");
  const Mesh mesh = io::load_model(folder / "m.obj", 0.001);
  const std::vector<Corner> corners = corners_of(mesh);
  REQUIRE(corners.size() == 3);
  CHECK(corners[1].position.x() == doctest::Approx(0.150));
  CHECK(corners[2].position.z() == doctest::Approx(0.060));
  CHECK_ERROR(io::load_model(folder / "m.obj", 0), ErrorCode::invalid_argument, "scale");
  CHECK_ERROR(io::load_model(folder / "m.obj", NAN), ErrorCode::invalid_argument, "scale");
}

TEST_CASE("Vertices nearer than a hundredth of a millimetre stay apart, equal ones are joined") {
  const TemporaryFolder folder;
  folder.write("m.obj", "v 0 0 0\nv 0.000004 0 0\nv 0 0.000004 0\nv 0 0 0\nv 0 0 0.000004\nf 1 2 3\nf 4 2 5\n");
  const Mesh mesh = io::load_model(folder / "m.obj");
  CHECK(mesh.triangles.size() == 2);
  CHECK(mesh.positions.size() == 4);
}

TEST_CASE("PLY: one coordinate a vertex, texture named in a comment, vertex colours") {
  const TemporaryFolder folder;
  folder.write("x.png", png_of(small_texture()));
  folder.write("m.ply",
               "ply\nformat ascii 1.0\ncomment TextureFile x.png\nelement vertex 3\nproperty float x\n"
               "property float y\nproperty float z\nproperty float s\nproperty float t\nproperty uchar red\n"
               "property uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 0 0 0 255 0 7\n1 0 0 1 0 0 255 8\n0 1 0 0 1 0 3 255\n3 0 1 2\n");
  const Mesh mesh = io::load_model(folder / "m.ply");
  const std::vector<Corner> corners = corners_of(mesh);
  REQUIRE(corners.size() == 3);
  CHECK(corners[2].uv == Eigen::Vector2f(0, 1));
  CHECK(corners[1].color == std::array<std::uint8_t, 4>{0, 255, 8, 255});
  CHECK(texture_of_triangle(mesh, 0).rgba == small_texture().rgba);
}

TEST_CASE("PLY: coordinates of face corners survive at seams, in text and in both byte orders") {
  const TemporaryFolder folder;
  folder.write("x y.png", png_of(small_texture()));
  const std::string elements =
      "comment TextureFile x y.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int flags\nelement face 2\n"
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n"
      "end_header\n";
  std::string body;
  SUBCASE("text") {
    body = "ply\nformat ascii 1.0\n" + elements +
           "0 0 0 10 20 30 0\n1 0 0 10 20 30 0\n1 1 0 10 20 30 0\n0 1 0 10 20 30 0\n"
           "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0.25 0.25 0.5 0.5 0 0.75 0\n";
  }
  const auto binary = [&elements](const char* format, bool swap) {
    std::string bytes = std::string("ply\nformat ") + format + " 1.0\n" + elements;
    const auto put = [&bytes, swap](const auto& value) {
      char raw[sizeof(value)];
      std::memcpy(raw, &value, sizeof(value));
      if (swap) {
        std::reverse(std::begin(raw), std::end(raw));
      }
      bytes.append(raw, sizeof(value));
    };
    const float vertices[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const auto& vertex : vertices) {
      for (const float value : vertex) {
        put(value);
      }
      bytes += "\x0a\x14\x1e";
      put(std::int32_t{-1});
    }
    const std::int32_t indices[2][3] = {{0, 1, 2}, {0, 2, 3}};
    const float coordinates[2][6] = {{0, 0, 1, 0, 1, 1}, {0.25F, 0.25F, 0.5F, 0.5F, 0, 0.75F}};
    for (int face = 0; face < 2; ++face) {
      bytes += '\x03';
      for (const std::int32_t index : indices[face]) {
        put(index);
      }
      bytes += '\x06';
      for (const float value : coordinates[face]) {
        put(value);
      }
      put(std::int32_t{0});
    }
    return bytes;
  };
  SUBCASE("little endian") { body = binary("binary_little_endian", false); }
  SUBCASE("big endian") { body = binary("binary_big_endian", true); }
  folder.write("m.PLY", body);
  const Mesh mesh = io::load_model(folder / "m.PLY");
  const std::vector<Corner> corners = corners_of(mesh);
  REQUIRE(corners.size() == 6);
  CHECK(mesh.positions.size() == 6);
  CHECK(mesh.materials.size() == 1);
  CHECK(corners[0].uv == Eigen::Vector2f(0, 0));
  CHECK(corners[3].position == corners[0].position);
  CHECK(corners[3].uv == Eigen::Vector2f(0.25F, 0.25F));
  CHECK(corners[5].uv == Eigen::Vector2f(0, 0.75F));
  CHECK(corners[4].color == std::array<std::uint8_t, 4>{10, 20, 30, 255});

  folder.write("short.ply", body.substr(0, body.size() - 20));
  CHECK_ERROR(io::load_model(folder / "short.ply"), ErrorCode::file, "short.ply", "complete");
}

TEST_CASE("PLY with bad faces says what is wrong") {
  const TemporaryFolder folder;
  folder.write("x.png", png_of(small_texture()));
  const auto ply = [&folder](const std::string& face) {
    return folder.write("m.ply",
                        "ply\nformat ascii 1.0\ncomment TextureFile x.png\nelement vertex 3\nproperty float x\n"
                        "property float y\nproperty float z\nelement face 1\nproperty list uchar int "
                        "vertex_indices\nproperty list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n0 1 0\n" +
                            face + "\n");
  };
  CHECK_ERROR(io::load_model(ply("3 0 1 7 6 0 0 1 0 0 1")), ErrorCode::file, "vertex 7", "there are 3");
  CHECK_ERROR(io::load_model(ply("3 0 1 2 4 0 0 1 0")), ErrorCode::file, "3 corners", "4 texture coordinates");
  const auto with_header = [&folder](const std::string& header) {
    return folder.write("h.ply", "ply\nformat ascii 1.0\n" + header);
  };
  const std::string face =
      "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n";
  CHECK_ERROR(io::load_model(with_header("element vertex 99999999999999\n" + face + "end_header")), ErrorCode::file,
              "99999999999999", "not possible");
  CHECK_ERROR(io::load_model(with_header(face + "end_header")), ErrorCode::file, "no element 'vertex'");
  CHECK_ERROR(io::load_model(with_header("element vertex 1\nproperty float x\nproperty float y\n" + face +
                                         "end_header\n0 0\n3 0 0 0 0\n")),
              ErrorCode::file, "x, y and z");
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  CHECK_ERROR(io::load_model(with_header(face + vertex + "end_header\n3 0 1 2 0\n0 0 0\n1 0 0\n0 1 0\n")),
              ErrorCode::file, "before its vertices");
  CHECK_ERROR(io::load_model(folder.write("h.ply", "ply\nformat binary 1.0\nend_header\n")), ErrorCode::file,
              "unknown format 'binary'");
  CHECK_ERROR(io::load_model(folder.write("h.ply", "plx\nformat ascii 1.0\nend_header\n")), ErrorCode::file, "'ply'");
  CHECK_ERROR(io::load_model(with_header(face)), ErrorCode::file, "header has no end");
  CHECK_ERROR(io::load_model(with_header("element vertex 1\nproperty quad x\n" + face + "end_header\n")),
              ErrorCode::file, "unknown type 'quad'");
  CHECK_ERROR(io::load_model(ply("3 0 one 2 6 0 0 1 0 0 1")), ErrorCode::file, "'one'", "not a number");
}

TEST_CASE("glTF: embedded texture, node transforms, v downwards in the file") {
  const TemporaryFolder folder;
  std::string data;
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const float coordinates[] = {0, 0, 1, 0, 0, 1};
  data.append(reinterpret_cast<const char*>(positions), sizeof(positions));
  data.append(reinterpret_cast<const char*>(coordinates), sizeof(coordinates));
  const std::uint16_t indices[] = {0, 1, 2};
  data.append(reinterpret_cast<const char*>(indices), sizeof(indices));
  const std::string png = png_of(small_texture());
  // The node turns x into y by 90 degrees about z and shifts by (10, 0, 0); its child mirrors x.
  folder.write("m.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"children":[1],"translation":[10,0,0],"rotation":[0,0,0.70710678,0.70710678]},
             {"mesh":0,"scale":[-1,1,1]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],
    "materials":[{"name":"paper","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
    "textures":[{"source":0}],"images":[{"uri":"data:image/png;base64,)" +
                             base64(png) + R"("}],
    "buffers":[{"byteLength":66,"uri":"data:application/octet-stream;base64,)" +
                             base64(data) + R"("}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},
                   {"buffer":0,"byteOffset":60,"byteLength":6}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
                 {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},
                 {"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}]})");
  const Mesh mesh = io::load_model(folder / "m.gltf");
  const std::vector<Corner> corners = corners_of(mesh);
  REQUIRE(corners.size() == 3);
  Texture opaque = small_texture();
  for (std::size_t i = 3; i < opaque.rgba.size(); i += 4) opaque.rgba[i] = 255;  // as the material is, by default
  CHECK(texture_of_triangle(mesh, 0).rgba == opaque.rgba);
  CHECK(mesh.materials[0].name == "paper");
  int seen = 0;
  for (const Corner& corner : corners) {
    // (1,0,0) -> mirrored (-1,0,0) -> turned (0,-1,0) -> (10,-1,0); (0,1,0) -> turned (-1,0,0) -> (9,0,0).
    if ((corner.position - Eigen::Vector3f(10, -1, 0)).norm() < 1e-5F) {
      ++seen;
      CHECK(corner.uv == Eigen::Vector2f(1, 1));  // v = 0, glTF's top, is v = 1 here
    }
    if ((corner.position - Eigen::Vector3f(9, 0, 0)).norm() < 1e-5F) {
      ++seen;
      CHECK(corner.uv == Eigen::Vector2f(0, 0));
    }
  }
  CHECK(seen == 2);
  // A mirrored part keeps its outside outside: the triangle's normal pointed to +z and still does.
  const Eigen::Vector3f normal =
      (corners[1].position - corners[0].position).cross(corners[2].position - corners[0].position);
  CHECK(normal.z() > 0.9F);
}

TEST_CASE("Models that cannot be used: one line that names the file and the fault") {
  const TemporaryFolder folder;
  CHECK_ERROR(io::load_model(folder / "none.obj"), ErrorCode::file, "none.obj", "does not exist");
  CHECK_ERROR(io::load_model(folder.path()), ErrorCode::file, "is a folder");
  CHECK_ERROR(io::load_model(folder.write("m.xyz123", "x")), ErrorCode::file, "m.xyz123", "not supported");
  CHECK_ERROR(io::load_model(folder.write("broken.gltf", "{\"asset\":")), ErrorCode::file, "broken.gltf",
              "cannot be read");
  CHECK_ERROR(io::load_model(folder.write("empty.ply", "")), ErrorCode::file, "empty.ply");
  CHECK_ERROR(io::load_model(folder.write("cloud.ply",
                                          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                                          "y\nproperty float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n")),
              ErrorCode::model, "cloud.ply", "no triangles");
  CHECK_ERROR(io::load_model(folder.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n")), ErrorCode::model,
              "points.obj", "no triangles");
  CHECK_ERROR(io::load_model(folder.write("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n")), ErrorCode::model,
              "nan.obj", "NaN");
  folder.write("lost.mtl", "newmtl m\nmap_Kd gone.png\n");
  CHECK_ERROR(
      io::load_model(folder.write("lost.obj", "mtllib lost.mtl\n" + kTriangleObj + "usemtl m\nf 1/1 2/2 3/3\n")),
      ErrorCode::file, "gone.png", "lost.obj", "does not exist");
  folder.write("gone.png", "this is no picture");
  CHECK_ERROR(io::load_model(folder / "lost.obj"), ErrorCode::file, "gone.png", "cannot be decoded");
}

TEST_CASE("A plain mesh has no appearance; a texture without coordinates covers nothing") {
  const TemporaryFolder folder;
  CHECK_FALSE(io::load_model(folder.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).has_appearance());
  folder.write("x.png", png_of(small_texture()));
  folder.write("m.mtl", "newmtl m\nmap_Kd x.png\n");
  const Mesh mesh =
      io::load_model(folder.write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
  CHECK_FALSE(mesh.has_appearance());
}

TEST_CASE("save_model writes what load_model reads back") {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.materials = {{"front side", small_texture()}, {"front side", {1, 1, {7, 8, 9, 0}}}, {"", {}}};
  mesh.positions = {{0.1234567F, -1e-7F, 3.3F}, {0.25F, 0, 0}, {0, 1.0F / 3, 0}, {0, 0, -0.7F}};
  mesh.texture_coordinates = {{0, 0}, {1, 0.123456F}, {0.3333333F, 1}, {2.5F, -1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 3}};
  mesh.triangle_materials = {0, 1, 2};
  io::save_model(folder / "out model.obj", mesh);
  const Mesh read = io::load_model(folder / "out model.obj");
  const std::vector<Corner> before = corners_of(mesh);
  const std::vector<Corner> after = corners_of(read);
  REQUIRE(before.size() == after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK((before[i].position - after[i].position).norm() < 1e-6F);
    CHECK((before[i].uv - after[i].uv).norm() < 1e-6F);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(texture_of_triangle(read, i).rgba == texture_of_triangle(mesh, i).rgba);
  }
  CHECK(read.positions.size() == 4);

  SUBCASE("vertex colours") {
    Mesh colored;
    colored.positions = mesh.positions;
    colored.triangles = mesh.triangles;
    colored.colors = {{0, 1, 2, 255}, {253, 254, 255, 255}, {77, 128, 3, 255}, {9, 9, 9, 255}};
    io::save_model(folder / "colored.obj", colored);
    const std::vector<Corner> expected = corners_of(colored);
    const std::vector<Corner> actual = corners_of(io::load_model(folder / "colored.obj"));
    REQUIRE(actual.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(actual[i].color == expected[i].color);
    }
    colored.colors[2][3] = 128;
    CHECK_ERROR(io::save_model(folder / "colored.obj", colored), ErrorCode::invalid_argument, "alpha");
  }
  SUBCASE("names and folders that do not do") {
    CHECK_ERROR(io::save_model(folder / "m.ply", mesh), ErrorCode::invalid_argument, "m.ply", ".obj");
    CHECK_ERROR(io::save_model(folder / "no/such/m.obj", mesh), ErrorCode::output, "cannot be written");
    CHECK_ERROR(io::save_model(folder / "m.obj", Mesh()), ErrorCode::model, "no triangles");
  }
}

TEST_CASE("Textures: grey, palette, 16 bits, alpha") {
  const TemporaryFolder folder;
  cv::imwrite((folder / "grey.png").string(), cv::Mat(2, 3, CV_8U, cv::Scalar(40)));
  CHECK(io::load_texture(folder / "grey.png").rgba[4] == 40);
  CHECK(io::load_texture(folder / "grey.png").rgba[7] == 255);
  cv::imwrite((folder / "deep.png").string(), cv::Mat(1, 1, CV_16UC3, cv::Scalar(3 * 257, 2 * 257, 257)));
  CHECK(io::load_texture(folder / "deep.png").rgba == std::vector<std::uint8_t>{1, 2, 3, 255});
  folder.write("alpha.png", png_of(small_texture()));
  CHECK(io::load_texture(folder / "alpha.png").rgba == small_texture().rgba);
  CHECK_ERROR(io::load_texture(folder / "none.png"), ErrorCode::file, "none.png", "does not exist");
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(16, 16, CV_8UC3, cv::Scalar(9, 9, 9)), jpeg);
  CHECK_ERROR(io::load_texture(folder.write("cut.jpg", std::string(jpeg.begin(), jpeg.end() - 8))), ErrorCode::file,
              "cut.jpg", "cannot be decoded");
  CHECK_ERROR(io::load_texture(folder.write("cut.png", png_of(small_texture()).substr(0, 30))), ErrorCode::file,
              "cut.png", "cannot be decoded");
}

TEST_CASE("The unit check names the likely unit") {
  const auto box = [](float size) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size / 2, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
  };
  const auto warning = [&box](float size) { return io::unit_warning(box(size), {}, {}).value_or(""); };
  CHECK(warning(150) ==
        "the object is 150 m across: are its coordinates millimetres? scale it by 0.001 (times the "
        "scale that was given, if any)");
  CHECK(warning(45).find("centimetres or inches? scale it by 0.01 or 0.0254 (times") != std::string::npos);
  CHECK(warning(2e5F).find("micrometres? scale it by 1e-06") != std::string::npos);
  CHECK(warning(2e-4F).find("0.2 mm across") != std::string::npos);
  CHECK(warning(2e-4F).find("multiply the scale by 1000") != std::string::npos);
  for (const float plausible : {0.0011F, 0.05F, 0.15F, 2.0F, 9.9F, 12.0F, 29.0F}) {
    CHECK(warning(plausible).empty());
  }

  Mesh away = box(0.15F);
  for (Eigen::Vector3f& position : away.positions) position.x() += 1e5F;
  CHECK(io::unit_warning(away, {}, {}).value_or("").find("move it to its origin") != std::string::npos);

  Camera camera{640, 480, 650, 650, 319.5, 239.5, {}};
  const auto at = [&](float size, double distance) {
    Pose pose = Pose::Identity();
    pose.translation().z() = distance;
    return io::unit_warning(box(size), pose, camera).value_or("");
  };
  CHECK(at(0.15F, 0.6).empty());
  CHECK(at(0.15F, 10).empty());
  CHECK(at(0.15F, 600).find("600 m away") != std::string::npos);
  CHECK(at(0.15F, 600).find("millimetres") != std::string::npos);
  CHECK(at(5, 0.1).find("scale it by 0.001") != std::string::npos);  // a 5 mm object in millimetres
  CHECK(at(150, 0.6).find("millimetres? scale it by 0.001") != std::string::npos);
  CHECK(at(15, 0.6).find("centimetres or inches? scale it by 0.01 or 0.0254") != std::string::npos);
  CHECK(at(9, 0.4).find("inches") != std::string::npos);
  CHECK(at(5.9F, 0.6).find("inches") != std::string::npos);
  CHECK(at(12, 30).empty());  // a lorry
  CHECK(at(40, 90).empty());  // an aeroplane
  const auto seen_by = [&](int width, int height, double fx, double fy) {
    const Camera lens{width, height, fx, fy, 0.5 * (width - 1), 0.5 * (height - 1), {}};
    Pose pose = Pose::Identity();
    pose.translation().z() = 0.6;
    return io::unit_warning(box(0.15F), pose, lens).value_or("");
  };
  CHECK(seen_by(640, 480, 4, 4).empty());  // the focal length is wrong, which camera_warning() tells
  CHECK(seen_by(640, 480, 65, 65).empty());
  camera.width = camera.height = 0;  // "fx fy cx cy" text knows no size
  CHECK(at(0.15F, 600).find("600 m away") != std::string::npos);
}
