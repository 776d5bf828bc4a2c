// Colours of vertices and facets in formats that leave open what full colour is, or which facets have one.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "support/files.hpp"

using namespace holdfast;
using holdfast::test::TemporaryFolder;

namespace {

using Color = std::array<std::uint8_t, 4>;

/// The colour of a triangle's first corner.
Color first_color(const Mesh& mesh, std::size_t triangle) {
  REQUIRE(!mesh.colors.empty());
  return mesh.colors[mesh.triangles[triangle][0]];
}

/// A PLY of one triangle whose vertices have colours of this type.
std::string ply(const std::string& type, const std::array<std::string, 3>& colors, const std::string& alpha = "") {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
  for (const char* name : {"x", "y", "z"}) text += "property float " + std::string(name) + "\n";
  for (const char* name : {"red", "green", "blue"}) text += "property " + type + " " + name + "\n";
  if (!alpha.empty()) text += "property " + type + " alpha\n";
  text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  return text + "0 0 0 " + colors[0] + " " + alpha + "\n1 0 0 " + colors[1] + " " + alpha + "\n0 1 0 " + colors[2] +
         " " + alpha + "\n3 0 1 2\n";
}

/// A binary STL of as many facets as attributes, one above the other.
std::string stl(std::string header, const std::vector<std::uint16_t>& attributes) {
  header.resize(80, ' ');
  const auto put = [&header](const auto& value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    header.append(raw, sizeof(value));
  };
  put(static_cast<std::uint32_t>(attributes.size()));
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    const auto z = static_cast<float>(i);
    for (const float value : {0.F, 0.F, 1.F, 0.F, 0.F, z, 1.F, 0.F, z, 0.F, 1.F, z}) put(value);
    put(attributes[i]);
  }
  return header;
}

}  // namespace

TEST_CASE(
    "PLY: colours of open types are shares of 1, numbers up to 255, or up to what the type holds, as all together "
    "are") {
  const TemporaryFolder folder;
  const auto seen = [&](const std::string& text) {
    const Mesh mesh = io::load_model(folder.write("m.ply", text));
    REQUIRE(mesh.colors.size() == 3);
    return mesh.colors;
  };
  const Color dark{1, 0, 1, 255}, plain{0, 128, 255, 255};
  for (const char* type : {"float", "double", "ushort", "uchar", "int"}) {
    CAPTURE(type);
    const std::vector<Color> colors = seen(ply(type, {"1 0 1", "0 128 255", "10 20 30"}));
    CHECK(colors[0] == dark);
    CHECK(colors[1] == plain);
    CHECK(colors[2] == Color{10, 20, 30, 255});
  }
  CHECK(seen(ply("float", {"1 0 1", "0 0.502 1.02", "0 0 0"}))[0] == Color{255, 0, 255, 255});
  CHECK(seen(ply("float", {"1 0 1", "0 0.502 1.02", "0 0 0"}))[1] == plain);
  CHECK(seen(ply("ushort", {"257 0 257", "0 32896 65535", "0 0 0"}))[0] == dark);
  CHECK(seen(ply("ushort", {"257 0 257", "0 32896 65535", "0 0 0"}))[1] == plain);
  // Alpha by itself.
  CHECK(seen(ply("float", {"1 0 1", "0 128 255", "0 0 0"}, "1"))[0] == dark);
  CHECK(seen(ply("float", {"0 0 0", "0 0.502 1", "0 0 0"}, "255"))[1] == plain);
}

TEST_CASE("PLY: colours of faces in floating point up to 255") {
  const TemporaryFolder folder;
  const Mesh mesh = io::load_model(folder.write(
      "m.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "2\nproperty list uchar int vertex_indices\nproperty float red\nproperty float green\nproperty float "
      "blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 1 0 0\n3 1 3 2 10 20 255\n"));
  CHECK(first_color(mesh, 0) == Color{1, 0, 0, 255});
  CHECK(first_color(mesh, 1) == Color{10, 20, 255, 255});
}

TEST_CASE("OFF: colours are shares of 1 or numbers up to 255, as all of the file together are") {
  const TemporaryFolder folder;
  const auto seen = [&](const std::string& text) { return io::load_model(folder.write("m.off", text)); };
  const std::string corners[] = {"0 0 0 ", "1 0 0 ", "0 1 0 "};
  const auto vertices = [&](const std::string& a, const std::string& b, const std::string& c) {
    return seen("COFF\n3 1 0\n" + corners[0] + a + "\n" + corners[1] + b + "\n" + corners[2] + c + "\n3 0 1 2\n");
  };
  CHECK(first_color(vertices("1 1 0", "10 20 30", "0 0 255"), 0) == Color{1, 1, 0, 255});
  CHECK(first_color(vertices("1 1 0", "0.2 0 0", "0 0 1"), 0) == Color{255, 255, 0, 255});
  CHECK(first_color(vertices("0.2 0 0 1", "1 1 0 1", "0 0 1 1"), 0) == Color{51, 0, 0, 255});
  CHECK(first_color(vertices("1 1 0 255", "10 20 30 255", "0 0 255 255"), 0) == Color{1, 1, 0, 255});
  const Mesh faces = seen("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 1 0 0\n3 1 3 2 0 200 0\n");
  CHECK(first_color(faces, 0) == Color{1, 0, 0, 255});
  CHECK(first_color(faces, 1) == Color{0, 200, 0, 255});
}

TEST_CASE("STL: colours of facets, in the order of either program that writes them") {
  const TemporaryFolder folder;
  const auto seen = [&](const std::string& header, const std::vector<std::uint16_t>& attributes) {
    return io::load_model(folder.write("m.stl", stl(header, attributes)));
  };
  constexpr std::uint16_t low = 31, bit = 0x8000, all = 0xffff;
  const std::string magics = "COLOR=abcd,MATERIAL=";
  const Color part{'a', 'b', 'c', 'd'}, red{255, 0, 0, 255}, blue{0, 0, 255, 255};
  // VisCAM: the bit says that there is a colour, blue is lowest.
  CHECK(seen("", {0, 0}).colors.empty());
  CHECK(seen("", {low, low}).colors.empty());
  Mesh mesh = seen("", {bit | low, 0});
  CHECK(first_color(mesh, 0) == blue);
  CHECK(first_color(mesh, 1) == Color{153, 153, 153, 255});
  // Magics: the bit says that there is none but the part's, red is lowest.
  mesh = seen(magics, {low, bit, all});
  CHECK(first_color(mesh, 0) == red);
  CHECK(first_color(mesh, 1) == part);
  CHECK(first_color(mesh, 2) == part);
  CHECK(first_color(seen(magics, {low, low << 10}), 1) == blue);
  // The part's colour all over is none.
  CHECK(seen(magics, {bit, bit}).colors.empty());
  CHECK(seen(magics, {0, 0}).colors.empty());
  // MeshLab: Magics' header and order, the bit with every colour.
  mesh = seen("COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f", {bit | low, bit | low << 10});
  CHECK(first_color(mesh, 0) == red);
  CHECK(first_color(mesh, 1) == blue);
}
