// The parts of a model stand where its format says.
#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::base64;
using holdfast::test::TemporaryFolder;

namespace {

/// A glTF of the triangle (0,0,0), (1,0,0), (0,1,0) with two morph targets: 1 up, and 2 along y; a third is too short.
/// `node` and `mesh`: more of what these have.
std::string gltf(const std::string& node, const std::string& mesh = "",
                 const std::string& targets = R"({"POSITION":1},{"POSITION":2})") {
  std::string data;
  for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F,     //
                            0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F,     //
                            0.F, 2.F, 0.F, 0.F, 2.F, 0.F, 0.F, 2.F, 0.F}) {  //
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    data.append(raw, sizeof(value));
  }
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0)" + node +
         R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[)" + targets + "]}]" + mesh +
         R"(}],"buffers":[{"byteLength":108,"uri":"data:;base64,)" + base64(data) +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36},
                               {"buffer":0,"byteOffset":72,"byteLength":36}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"},
                 {"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}]})";
}

/// The place of the corner that stands at (1, 0, 0) in the file, and the remarks.
struct Placed {
  Eigen::Vector3f corner;
  std::vector<std::string> remarks;
};

Placed placed(const TemporaryFolder& folder, const std::string& text) {
  std::vector<std::string> remarks;
  const Mesh mesh = io::load_model(folder.write("m.gltf", text), 1, &remarks);
  REQUIRE(mesh.triangles.size() == 1);
  return {mesh.positions[mesh.triangles[0][1]], remarks};
}

}  // namespace

TEST_CASE("glTF: morph targets move the mesh by the weights of the node, else of the mesh, else not at all") {
  const TemporaryFolder folder;
  const auto corner = [&](const std::string& node, const std::string& mesh) {
    const Placed seen = placed(folder, gltf(node, mesh));
    CHECK(seen.remarks.empty());
    return seen.corner;
  };
  const std::string on_mesh = R"(,"weights":[1,0.25])";
  CHECK(corner("", "") == Eigen::Vector3f(1, 0, 0));
  CHECK(corner("", on_mesh) == Eigen::Vector3f(1, 0.5F, 1));
  CHECK(corner(R"(,"weights":[0,-1])", on_mesh) == Eigen::Vector3f(1, -2, 0));
  CHECK(corner(R"(,"scale":[2,2,2])", R"(,"weights":[0.5])") == Eigen::Vector3f(2, 0, 1));
  CHECK_ERROR(io::load_model(folder.write("m.gltf", gltf("", on_mesh, R"({"POSITION":3})"))), ErrorCode::file, "m.gltf",
              "morph target", "length");
  CHECK_ERROR(io::load_model(folder.write("m.gltf", gltf("", R"(,"weights":["a"])"))), ErrorCode::file, "'weights'");
}

TEST_CASE("glTF: of a mesh with a skin the node's transform does not count, and instances are told of") {
  const TemporaryFolder folder;
  const std::string moved = R"(,"translation":[5,5,5])";
  CHECK(placed(folder, gltf(moved)).corner == Eigen::Vector3f(6, 5, 5));
  const Placed skinned = placed(folder, gltf(moved + R"(,"skin":0)"));
  CHECK(skinned.corner == Eigen::Vector3f(1, 0, 0));
  REQUIRE(skinned.remarks.size() == 1);
  CHECK(skinned.remarks[0].find("skin") != std::string::npos);
  const Placed once = placed(folder, gltf(moved + R"(,"extensions":{"EXT_mesh_gpu_instancing":{}})"));
  CHECK(once.corner == Eigen::Vector3f(6, 5, 5));
  REQUIRE(once.remarks.size() == 1);
  CHECK(once.remarks[0].find("EXT_mesh_gpu_instancing") != std::string::npos);
}

TEST_CASE("COLLADA: the axis that points up and the unit are applied") {
  const TemporaryFolder folder;
  const auto apex = [&](const std::string& asset) {
    const Mesh mesh = io::load_model(folder.write("m.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>)" +
                                                               asset + R"(</asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 0 2</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)"));
    return mesh.positions[mesh.triangles[0][2]];
  };
  CHECK((apex("<up_axis>Y_UP</up_axis>") - Eigen::Vector3f(0, 0, 2)).norm() < 1e-5F);
  CHECK((apex("<up_axis>Z_UP</up_axis>") - Eigen::Vector3f(0, 2, 0)).norm() < 1e-5F);
  CHECK((apex(R"(<unit meter="0.01"/><up_axis>Y_UP</up_axis>)") - Eigen::Vector3f(0, 0, 0.02F)).norm() < 1e-5F);
}
