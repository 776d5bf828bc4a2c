// Camera files and tables that are made, or broken, so that reading them as they stand would take all memory, all stack
// or all day: refused at once, in one line.
#include <doctest/doctest.h>

#include <chrono>
#include <sstream>
#include <string>

#include "evaluation/sequence.hpp"
#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::TemporaryFolder;

namespace {

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

/// Refused as a camera, naming the file, within a second.
void check_refused(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  CAPTURE(name);
  const auto begin = std::chrono::steady_clock::now();
  CHECK_ERROR(io::load_camera(folder.write(name, text)), ErrorCode::camera, name.c_str());
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(5));
}

}  // namespace

TEST_CASE("YAML: aliases are read as what they stand for, loops and floods are refused") {
  const TemporaryFolder folder;
  const Camera camera = io::load_camera(
      folder.write("shared.yaml",
                   "size: &s 640\nimage_width: *s\nimage_height: 480\ncamera_matrix: [600, 0, 320, 0, 600, 240, 0, 0, "
                   "1]\ndistortion: &d [0, 0, 0, 0]\nother: *d\n"));
  CHECK(camera.width == 640);
  check_refused(folder, "loop.yaml", "fx: &a [1, *a]\n");
  check_refused(folder, "loop2.yaml", "fx: &a {b: *a}\n");
  std::ostringstream flood;
  flood << "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 10; ++i) {
    flood << 'a' << i << ": &a" << i << " [";
    for (int k = 0; k < 10; ++k) flood << (k > 0 ? ", " : "") << "*a" << i - 1 << ' ';
    flood << "]\n";
  }
  check_refused(folder, "flood.yaml", flood.str() + "camera_matrix: *a9\n");
}

TEST_CASE("Deeply nested documents of every syntax are refused") {
  const TemporaryFolder folder;
  for (const int depth : {70, 1000, 100000}) {
    CAPTURE(depth);
    check_refused(folder, "deep.json", "{\"fx\":" + repeated("[", depth) + repeated("]", depth) + "}");
    check_refused(folder, "deep2.json", repeated("{\"a\":", depth));
    check_refused(folder, "deep.yaml", "fx: " + repeated("[", depth) + repeated("]", depth));
    check_refused(folder, "deep2.yaml", "fx: " + repeated("{a: ", depth) + "1" + repeated("}", depth));
    check_refused(folder, "deep3.yaml", "fx:\n " + repeated("- ", depth) + "1\n");
    check_refused(folder, "deep.xml", "<opencv_storage>" + repeated("<a>", depth) + repeated("</a>", depth));
  }
}

TEST_CASE("XML that is none, and files that have no end") {
  const TemporaryFolder folder;
  for (const char* text : {"<", "<?xml", "<?xml version=\"1\"?>", "<a", "<a b=\"", "<a></b>", "<a><!-- ", "<a>1</a",
                           "<?xml version=\t \"?><opencv_storage></opencv_s\"?><ope", "< a></ a>",
                           "<a><![CDATA[x]]></a>", "<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>", "</a>", "<a/>"}) {
    CAPTURE(text);
    check_refused(folder, "odd.xml", text);
  }
  check_refused(folder, "keys.yaml", "? [1, 2]\n: 3\n");
  CHECK_ERROR(io::load_camera("/dev/zero"), ErrorCode::file, "/dev/zero", "more than 1000000 bytes");
  CHECK_ERROR(io::load_camera(folder.write("large.yml", std::string(1'000'001, ' '))), ErrorCode::file, "large.yml",
              "more than 1000000 bytes");
  CHECK_ERROR(io::load_model("/dev/zero"), ErrorCode::file, "/dev/zero");
}

TEST_CASE("BOP's tables: deeply nested, or of another type than they must be") {
  const TemporaryFolder folder;
  folder.write("rgb/000000.png", "");
  const auto table = [&folder](const std::string& truth, const std::string& cameras) {
    folder.write("scene_camera.json", cameras);
    folder.write("scene_gt.json", truth);
    return folder.path();
  };
  const std::string camera = R"({"0":{"cam_K":[600,0,320,0,600,240,0,0,1],"depth_scale":1}})";
  const std::string pose = R"({"0":[{"cam_R_m2c":[1,0,0,0,1,0,0,0,1],"cam_t_m2c":[0,0,600],"obj_id":1}]})";
  for (const std::string& odd :
       {std::string("[]"), std::string("7"), std::string("\"x\""), std::string("null"), std::string(R"({"0":7})"),
        std::string(R"({"0":"x"})"), std::string(R"({"0":[7]})"), std::string(R"({"x":[]})"),
        std::string(R"({"99999999999999999999":[]})"), std::string(R"({"0":{"a":{}}})"),
        std::string(R"({"0":[{"cam_R_m2c":"x","cam_t_m2c":[0,0,600],"obj_id":1}]})"),
        std::string(R"({"0":[{"cam_R_m2c":[1,0,0,0,1,0,0,0,1],"cam_t_m2c":[0,0,"x"],"obj_id":"one"}]})"),
        "{\"0\":" + repeated("[", 1000) + repeated("]", 1000) + "}", "{\"0\":" + repeated("[", 1000000)}) {
    CAPTURE(odd.substr(0, 100));
    for (const auto& path : {table(odd, camera), table(pose, odd)}) {
      const holdfast::test::CaughtError caught =
          holdfast::test::error_of([&] { (void)evaluation::load_sequence(path, std::nullopt); });
      CAPTURE(caught.message);
      CHECK(caught.thrown);
      CHECK(caught.message.find(".json") != std::string::npos);
    }
  }
}
