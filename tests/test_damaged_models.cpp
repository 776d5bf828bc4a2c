// Model files that are cut, damaged or made to do harm: one line that names the file, never a crash, nor more memory
// than the file is worth.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::TemporaryFolder;

namespace {

long peak_megabytes() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_maxrss / 1024;
}

const std::string kPlyHeader =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n";

std::string text_ply(const std::string& faces) {
  return "ply\nformat ascii 1.0\n" + kPlyHeader + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n" + faces;
}

template <class Value>
void put(std::string& bytes, Value value) {
  char raw[sizeof(value)];
  std::memcpy(raw, &value, sizeof(value));
  bytes.append(raw, sizeof(value));
}

std::string binary_ply(const std::array<std::int32_t, 6>& indices) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n" + kPlyHeader;
  for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 1.F, 0.F}) put(bytes, value);
  for (std::size_t face = 0; face < 2; ++face) {
    bytes += '\x03';
    for (std::size_t k = 0; k < 3; ++k) put(bytes, indices[3 * face + k]);
  }
  return bytes;
}

/// Corners of two facets.
constexpr std::array<std::array<float, 9>, 2> kFacets = {{{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 0, 1, 0}}};

std::string text_stl() {
  std::string text = "solid vertex of two\n";
  for (const auto& corners : kFacets) {
    text += "facet normal 0 0 1\n outer loop\n";
    for (std::size_t k = 0; k < 9; ++k)
      text += (k % 3 == 0 ? "  vertex " : " ") + std::to_string(corners[k]) + (k % 3 == 2 ? "\n" : "");
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid vertex of two\n";
}

std::string binary_stl(std::string header, const std::array<std::uint16_t, 2>& attributes) {
  header.resize(80, ' ');
  put(header, std::uint32_t{2});
  for (std::size_t facet = 0; facet < 2; ++facet) {
    for (const float value : {0.F, 0.F, 1.F}) put(header, value);
    for (const float value : kFacets[facet]) put(header, value);
    put(header, attributes[facet]);
  }
  return header;
}

std::string off(const std::string& faces) { return "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n" + faces; }

std::string glb(const std::string& document, std::uint32_t said, std::uint32_t total) {
  std::string bytes = "glTF";
  for (const std::uint32_t value : {std::uint32_t{2}, total, said}) put(bytes, value);
  return bytes + "JSON" + document;
}

/// Loads a file whatever is in it: it is read, or an Error says why not.
void load_or_refuse(const std::filesystem::path& path) {
  try {
    const Mesh mesh = io::load_model(path);
    mesh.validate();
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find(path.filename().string()) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("PLY: cut anywhere, in text and bytes, it is refused or what is whole is read") {
  const TemporaryFolder folder;
  for (const std::string& whole : {text_ply("3 0 1 2\n3 0 2 3\n"), binary_ply({0, 1, 2, 0, 2, 3})}) {
    CHECK(io::load_model(folder.write("whole.ply", whole)).triangles.size() == 2);
    for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
      CAPTURE(length);
      CHECK_ERROR(io::load_model(folder.write("cut.ply", whole.substr(0, length))), ErrorCode::file, "cut.ply");
    }
  }
}

TEST_CASE("STL: cut anywhere, in text and bytes, it is refused or what is whole is read") {
  const TemporaryFolder folder;
  const std::string text = text_stl(), binary = binary_stl("solid in name", {0, 0});
  for (const std::string& whole : {text, binary}) {
    const Mesh mesh = io::load_model(folder.write("whole.stl", whole), 0.5);
    CHECK(mesh.triangles.size() == 2);
    CHECK(mesh.colors.empty());
    REQUIRE(mesh.positions.size() == 4);
    CHECK(mesh.positions[3] == Eigen::Vector3f(0, 0.5, 0));
  }
  for (std::size_t length = 0; length < binary.size(); ++length) {
    CAPTURE(length);
    const auto path = folder.write("cut.stl", binary.substr(0, length));
    const test::CaughtError cut = test::error_of([&] { (void)io::load_model(path); });
    CHECK(cut.thrown);
    CHECK(cut.message.find("cut.stl") != std::string::npos);
  }
  for (std::size_t length = 0; length < text.size(); ++length) {
    CAPTURE(length);
    const std::string cut = text.substr(0, length);
    const auto path = folder.write("cut.stl", cut);
    if (cut.find("endsolid") != cut.npos) {
      CHECK(io::load_model(path).triangles.size() == 2);
    } else {
      const test::CaughtError error = test::error_of([&] { (void)io::load_model(path); });
      CHECK(error.thrown);
      CHECK(error.message.find("cut.stl") != std::string::npos);
    }
  }
  // A cut after a whole facet, and one in a second solid.
  const std::string facet = text.substr(0, text.find("endfacet") + 9);
  CHECK_ERROR(io::load_model(folder.write("facet.stl", facet)), ErrorCode::file, "facet.stl", "endsolid", "complete");
  CHECK_ERROR(io::load_model(folder.write("second.stl", text + facet)), ErrorCode::file, "endsolid");
  CHECK(io::load_model(folder.write("both.stl", text + text)).triangles.size() == 2 * 2);
  CHECK_ERROR(io::load_model(folder.write("n.stl", "solid a\nfacet\nvertex 0 x 0\nendfacet\n")), ErrorCode::file,
              "n.stl", "line 3", "'x'");
  CHECK_ERROR(io::load_model(folder.write("two.stl", "solid a\nfacet\nvertex 0 0 0\nfacet\n")), ErrorCode::file,
              "two.stl", "line 4");
}

TEST_CASE("STL: text and bytes are told apart, whatever stands before and behind") {
  const TemporaryFolder folder;
  const std::string binary = binary_stl("solid in name", {0, 0});
  for (const std::string& whole :
       {"\xef\xbb\xbf" + text_stl(), "\r\n " + text_stl(), binary + std::string(2, '\0'), binary + "solid",
        text_stl().substr(0, text_stl().rfind("endsolid")) + "end solid\n"}) {
    CHECK(io::load_model(folder.write("m.stl", whole)).triangles.size() == 2);
  }
  std::string padded = binary;
  std::fill_n(padded.begin() + 13, 80 - 13, '\0');
  CHECK(io::load_model(folder.write("m.stl", padded + "\r\n")).triangles.size() == 2);
  CHECK_ERROR(io::load_model(folder.write("cut.stl", padded.substr(0, 180))), ErrorCode::file, "cut.stl",
              "180 of 184 bytes");
}

TEST_CASE("Indices that no vertex has are refused in every format") {
  const TemporaryFolder folder;
  for (const std::int32_t index : {4, 70000, -1, -2147483647}) {
    CAPTURE(index);
    const std::string number = std::to_string(index);
    CHECK_ERROR(io::load_model(folder.write("b.ply", binary_ply({0, 1, 2, 0, 2, index}))), ErrorCode::file, "b.ply",
                number.c_str(), "there are 4");
    CHECK_ERROR(io::load_model(folder.write("t.ply", text_ply("3 0 1 2\n3 0 2 " + number + "\n"))), ErrorCode::file,
                "t.ply", number.c_str(), "there are 4");
    CHECK_ERROR(io::load_model(folder.write("m.off", off("3 0 1 2\n3 0 2 " + number + "\n"))), ErrorCode::file, "m.off",
                number.c_str(), "there are 4");
  }
  for (const char* index : {"5", "0", "-5", "99999999999999999999"}) {
    CAPTURE(index);
    const std::string obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 ";
    CHECK_ERROR(io::load_model(folder.write("m.obj", obj + index + "\n")), ErrorCode::file, "m.obj", "line 6",
                "there are 4");
    CHECK_ERROR(io::load_model(folder.write(
                    "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/" + std::string(index) + "\n")),
                ErrorCode::file, "m.obj", "texture coordinate");
  }
}

TEST_CASE("Faces of fewer than three corners are left out") {
  const TemporaryFolder folder;
  for (const char* few : {"0\n", "1 2\n", "2 0 1\n"}) {
    CAPTURE(few);
    CHECK(io::load_model(folder.write("m.ply", text_ply(few + std::string("3 0 1 2\n")))).triangles.size() == 1);
    CHECK(io::load_model(folder.write("m.off", off(few + std::string("3 0 1 2\n")))).triangles.size() == 1);
  }
  CHECK(io::load_model(folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\nf 1 2\nf\nf 1 2 3\n")).triangles.size() ==
        1);
}

TEST_CASE("Counts that a file cannot hold are refused before anything is made of them") {
  const TemporaryFolder folder;
  const long before = peak_megabytes();
  for (const char* count : {"4000000000", "99999999999999999999", "-1"}) {
    CAPTURE(count);
    const std::string header = std::string("ply\nformat ascii 1.0\nelement vertex ") + count +
                               "\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    CHECK_ERROR(io::load_model(folder.write("many.ply", header)), ErrorCode::file, "many.ply");
    CHECK_ERROR(io::load_model(folder.write("many.off", std::string("OFF\n") + count + " 1 0\n0 0 0\n3 0 0 0\n")),
                ErrorCode::file, "many.off");
  }
  CHECK_ERROR(io::load_model(folder.write("list.ply", text_ply("4000000000 0 1 2\n3 0 1 2\n"))), ErrorCode::file,
              "list.ply");
  // 22 bytes that say they hold 4 GB.
  CHECK_ERROR(io::load_model(folder.write("small.glb", glb("{}", 0xfffffff0U, 22))), ErrorCode::file, "small.glb");
  const std::string huge =
      R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4000000000,"uri":"data:;base64,AAAA"}],
          "bufferViews":[{"buffer":0,"byteLength":4000000000}],
          "accessors":[{"bufferView":0,"componentType":5126,"count":300000000,"type":"VEC3"}],
          "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]})";
  CHECK_ERROR(io::load_model(folder.write("huge.gltf", huge)), ErrorCode::file, "huge.gltf");
  CHECK(peak_megabytes() - before < 100);
}

TEST_CASE("glTF: elements without data are zeros where they are few, and refused where a short file has millions") {
  const TemporaryFolder folder;
  // `count` vertices at the origin but for 1 and 2, of which the file has places.
  const auto zeros = [&folder](const std::string& count, const std::string& nodes) {
    const std::string text = R"({"asset":{"version":"2.0"},
          "buffers":[{"byteLength":26,"uri":"data:;base64,AQIAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAA="}],
          "bufferViews":[{"buffer":0,"byteLength":2},{"buffer":0,"byteOffset":2,"byteLength":24}],
          "accessors":[{"componentType":5126,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":0,
            "componentType":5121},"values":{"bufferView":1}},"count":)";
    return folder.write(
        "zeros.gltf",
        text + count + R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[)" + nodes + "]}");
  };
  const std::string node = R"({"mesh":0})";
  const Mesh mesh = io::load_model(zeros("3", node));
  REQUIRE(mesh.positions.size() == 3);
  CHECK(mesh.positions[0] == Eigen::Vector3f::Zero());
  CHECK(mesh.positions[1] == Eigen::Vector3f::UnitX());
  CHECK(mesh.positions[2] == Eigen::Vector3f::UnitY());
  CHECK(io::load_model(zeros("1000000", node)).triangles.size() == 1);
  const long before = peak_megabytes();
  CHECK_ERROR(io::load_model(zeros("60000000", node)), ErrorCode::file, "zeros.gltf", "no data for 60000000 elements");
  CHECK(peak_megabytes() - before < 100);
  std::string nodes = node;
  for (int i = 0; i < 8; ++i) nodes += "," + node;
  CHECK_ERROR(io::load_model(zeros("1000000", nodes)), ErrorCode::file, "zeros.gltf", "no data for 5000000 elements");
}

TEST_CASE("glTF: triangles without area count, however often a short file shows them") {
  const TemporaryFolder folder;
  // Zeros: 30,000 vertices in one place, shown by 1001 nodes.
  std::string nodes = R"({"mesh":0})";
  for (int i = 0; i < 1000; ++i) nodes += R"(,{"mesh":0})";
  const std::string document =
      R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":360000,"uri":"data:;base64,)" + std::string(480000, 'A') +
      R"("}],"bufferViews":[{"buffer":0,"byteLength":360000}],"accessors":[{"bufferView":0,"componentType":5126,
          "count":30000,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[)" +
      nodes + "]}";
  CHECK_ERROR(io::load_model(folder.write("flat.gltf", document)), ErrorCode::model, "flat.gltf", "10 million");
}

TEST_CASE("glTF: nesting, loops and indices that lead nowhere") {
  const TemporaryFolder folder;
  for (const int depth : {100, 1000000}) {
    const std::string deep(static_cast<std::size_t>(depth), '[');
    CHECK_ERROR(io::load_model(folder.write("deep.gltf", "{\"extras\":" + deep)), ErrorCode::file, "deep.gltf");
  }
  const auto nodes = [&folder](const std::string& list, const std::string& more = "") {
    return folder.write("n.gltf",
                        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":)" + list + more + "}");
  };
  CHECK_ERROR(io::load_model(nodes(R"([{"children":[1]},{"children":[0]}])")), ErrorCode::file, "n.gltf", "twice");
  CHECK_ERROR(io::load_model(nodes(R"([{"children":[7]}])")), ErrorCode::file, "n.gltf", "nodes 7");
  CHECK_ERROR(io::load_model(nodes(R"([{"mesh":3}])")), ErrorCode::file, "n.gltf", "meshes 3");
  CHECK_ERROR(io::load_model(nodes(R"([{"mesh":-1}])")), ErrorCode::file, "n.gltf", "mesh");
  CHECK_ERROR(io::load_model(nodes(R"([{"mesh":"x"}])")), ErrorCode::file, "n.gltf", "mesh");
  CHECK_ERROR(io::load_model(nodes("[7]")), ErrorCode::file, "n.gltf", "nodes 0");
  // Brackets in strings are none.
  std::string named = R"([{"name":"\"\\\"[)";
  named.append(100, '{').append(R"(","mesh":3}])");
  CHECK_ERROR(io::load_model(nodes(named)), ErrorCode::file, "n.gltf", "meshes 3");
  // A chain of parts deeper than any stack.
  std::string chain = "[";
  for (int i = 1; i < 200000; ++i) chain += "{\"children\":[" + std::to_string(i) + "]},";
  CHECK_ERROR(io::load_model(nodes(chain + "{}]")), ErrorCode::model, "n.gltf", "no triangles");
  CHECK_ERROR(io::load_model(folder.write("one.gltf", R"({"asset":{"version":"1.0"}})")), ErrorCode::file, "one.gltf",
              "version 2");
}

TEST_CASE("Bytes changed at random never do more than be refused") {
  const TemporaryFolder folder;
  const std::string obj =
      "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv .5 .5 1 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
      "f 1/1 2/2 3/3\nf 1/1 2/2 4/3\nf -1 -2 -3\n";
  folder.write("m.mtl", "newmtl m\nKd 1 0 0\n");
  const std::vector<std::pair<std::string, std::string>> files = {
      {"r.ply", text_ply("3 0 1 2\n3 0 2 3\n")},
      {"s.ply", binary_ply({0, 1, 2, 0, 2, 3})},
      {"r.off", off("3 0 1 2\n4 0 1 2 3\n")},
      {"r.stl", text_stl()},
      {"s.stl", binary_stl("", {0, 0x8000})},
      {"r.obj", obj},
      {"r.glb", glb(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[]})", 62, 82)},
      {"r.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data:;base64,)" +
                     std::string(48, 'A') +
                     R"("}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],"accessors":[{"bufferView":0,
                     "componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":
                     {"POSITION":0}}]}],"nodes":[{"mesh":0}]})"}};
  std::mt19937 random(7);
  for (const auto& [name, whole] : files) {
    CAPTURE(name);
    for (int round = 0; round < 2000; ++round) {
      std::string bytes = whole;
      for (unsigned change = 0; change <= random() % 4; ++change) {
        bytes[random() % bytes.size()] = static_cast<char>(random() % 3 == 0 ? random() % 256 : '0' + random() % 12);
      }
      load_or_refuse(folder.write(name, bytes));
    }
  }
}

TEST_CASE("What a picture takes is known from its header") {
  const TemporaryFolder folder;
  std::vector<std::uint8_t> encoded;
  // 32000 x 32000 pixels of one colour: 125 kB that decode to gigabytes.
  cv::imencode(".png", cv::Mat(1, 1, CV_8U, cv::Scalar(7)), encoded);
  std::string bytes(encoded.begin(), encoded.end());
  for (const std::size_t at : {std::size_t{16}, std::size_t{20}}) bytes.replace(at, 4, std::string("\0\0\x7d\0", 4));
  const long before = peak_megabytes();
  CHECK_ERROR(io::load_texture(folder.write("large.png", bytes)), ErrorCode::file, "large.png", "32000x32000");
  CHECK(peak_megabytes() - before < 50);

  const cv::Mat picture(5, 7, CV_8UC3, cv::Scalar(30, 20, 10));
  for (const char* extension : {".png", ".jpg", ".bmp", ".ppm", ".webp", ".tiff"}) {
    CAPTURE(extension);
    REQUIRE(cv::imencode(extension, picture, encoded));
    const Texture read =
        io::load_texture(folder.write(std::string(extension).substr(1), {encoded.begin(), encoded.end()}));
    CHECK(read.width == 7);
    CHECK(read.height == 5);
    for (std::size_t length = 0; length < 64; ++length) {  // a header that is cut
      const test::CaughtError caught =
          test::error_of([&] { io::check_image(encoded.data(), std::min(length, encoded.size() - 1), "cut"); });
      CHECK((!caught.thrown || caught.says(ErrorCode::file, {"cut"})));
    }
  }
  // A byte of the picture is another one: libpng would tell that on stderr. One of a comment's does no harm.
  REQUIRE(cv::imencode(".png", cv::Mat(50, 70, CV_8UC3, cv::Scalar(30, 20, 10)), encoded));
  std::string png(encoded.begin(), encoded.end());
  png.insert(33, std::string("\0\0\0\3tEXta\0b____", 15));
  io::check_image(png.data(), png.size(), "commented.png");
  png[png.find("IDAT") + 12] ^= 1;
  CHECK_ERROR(io::check_image(png.data(), png.size(), "flipped.png"), ErrorCode::file, "flipped.png", "damaged");
  // A JPEG that promises more than its bytes can hold; of one colour it is as small as it can be.
  REQUIRE(cv::imencode(".jpg", cv::Mat(2000, 2000, CV_8UC1, cv::Scalar(128)), encoded));
  io::check_image(encoded.data(), encoded.size(), "grey.jpg");
  REQUIRE(cv::imencode(".jpg", cv::Mat(8, 8, CV_8UC1, cv::Scalar(128)), encoded));
  std::string jpeg(encoded.begin(), encoded.end());
  jpeg.replace(jpeg.find("\xff\xc0") + 5, 4, "\x1f\x40\x1f\x40");
  CHECK_ERROR(io::check_image(jpeg.data(), jpeg.size(), "claim.jpg"), ErrorCode::file, "claim.jpg", "damaged");
  CHECK_ERROR(io::load_texture(folder.write("short.bmp", "BM")), ErrorCode::file, "short.bmp", "cannot be decoded");
}
