// Messages on a model that cannot be read: what to do about it, and "is the file complete?" only where it may not
// be.
#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::TemporaryFolder;

namespace {

/// The end of the one line that a model is refused with.
std::string advice_on(const std::filesystem::path& path) {
  const test::CaughtError error = test::error_of([&] { (void)io::load_model(path); });
  CHECK(error.thrown);
  return error.message.substr(error.message.rfind(": ") + 2);
}

/// A glTF of one triangle with so many indices, of which three are there.
std::string indexed(const std::string& count, const std::string& type = "SCALAR") {
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0}]}],
      "buffers":[{"byteLength":39,"uri":"data:;base64,AAECAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
      "bufferViews":[{"buffer":0,"byteLength":3},{"buffer":0,"byteOffset":3,"byteLength":36}],
      "accessors":[{"bufferView":0,"componentType":5121,"type":")" +
         type + R"(","count":)" + count + R"(},{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}]})";
}

}  // namespace

TEST_CASE("A model that is whole, but of a kind that is not supported, is to be exported otherwise") {
  const TemporaryFolder folder;
  const std::string complete = "is the file complete?";
  CHECK(advice_on(folder.write("one.gltf", R"({"asset":{"version":"1.0"}})")) == "export it as that");
  std::string packed = indexed("3");
  packed.replace(packed.find(R"("byteLength":3})"), 14,
                 R"("byteLength":3,"extensions":{"EXT_meshopt_compression":{}})");
  CHECK(advice_on(folder.write("packed.gltf", packed)) == "export it without");
  CHECK(advice_on(folder.write("four.off", "4OFF\n1 0\n0 0 0 0\n")) == "export OFF or COFF");
  CHECK(advice_on(folder.write("binary.off", "OFF BINARY\n")) == "export it as text");
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  CHECK(advice_on(folder.write(
            "faces.ply", "ply\nformat ascii 1.0\n" + face + vertex + "end_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n")) ==
        "export it with the vertices first");
  const std::string points = "decimal points instead of commas";
  CHECK(advice_on(folder.write("comma.off", "OFF\n3 1\n0 0 0\n0,5 0 0\n0 1 0\n3 0 1 2\n")) == "write " + points);
  CHECK(advice_on(folder.write("comma.stl", "solid\nfacet\nvertex 0,5 0 0\nendfacet\nendsolid\n")) ==
        "write " + points);
  CHECK(advice_on(folder.write("comma.obj", "v 0,5 0 0\n")) == "write " + points);
  CHECK(advice_on(folder.write("comma.ply", "ply\nformat ascii 1.0\n" + vertex + "end_header\n0,5 0 0\n")) ==
        "write " + points);
  // Cut short.
  CHECK(advice_on(folder.write("cut.gltf", R"({"asset":{"version)")) == complete);
  CHECK(advice_on(folder.write("cut.off", "OFF\n3 1\n0 0 0\n")) == complete);
  CHECK(advice_on(folder.write("cut.ply", "ply\nformat ascii 1.0\n" + vertex + "end_header\n0 0 0\n")) == complete);
}

TEST_CASE("glTF: of more indices than the file has room for it is said that they reach beyond it") {
  const TemporaryFolder folder;
  CHECK(io::load_model(folder.write("m.gltf", indexed("3"))).triangles.size() == 1);
  CHECK_ERROR(io::load_model(folder.write("m.gltf", indexed("4000000000"))), ErrorCode::file, "m.gltf",
              "4000000000 elements reaches beyond", "complete");
  CHECK_ERROR(io::load_model(folder.write("m.gltf", indexed("1", "VEC2"))), ErrorCode::file, "no list of indices",
              "export it anew");
}

TEST_CASE("A file that stands in a model's place is named as what it is") {
  const TemporaryFolder folder;
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:1234\nsize 1234\n";
  const std::string page = "\xef\xbb\xbf\n<!DOCTYPE html><html></html>\n";
  for (const char* name : {"m.obj", "m.ply", "m.stl", "m.off", "m.glb", "m.gltf", "m.dae", "m.fbx"}) {
    CAPTURE(name);
    CHECK_ERROR(io::load_model(folder.write(name, pointer)), ErrorCode::file, name, "Git LFS", "git lfs pull");
    CHECK_ERROR(io::load_model(folder.write(name, page)), ErrorCode::file, name, "web page", "download");
  }
  CHECK_ERROR(io::load_texture(folder.write("a.png", pointer)), ErrorCode::file, "image", "a.png", "Git LFS");
  CHECK_ERROR(io::load_camera(folder.write("c.yml", "<HTML>")), ErrorCode::file, "c.yml", "web page");
}

TEST_CASE("Files of CAD programs are to be exported as triangles") {
  const TemporaryFolder folder;
  const std::string step = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n";
  for (const char* name : {"m.step", "m.STP", "m.iges", "m.SLDPRT"}) {
    CAPTURE(name);
    CHECK_ERROR(io::load_model(folder.write(name, step)), ErrorCode::file, name, "CAD", "STL or OBJ");
  }
}
