#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "separate_files.hpp"
#include "support/check_error.hpp"
#include "support/files.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using namespace holdfast::app;
using namespace holdfast::test;

namespace {

Mesh textured_triangle(std::size_t materials) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}};
  for (std::size_t i = 0; i < materials; ++i) {
    mesh.triangles.push_back({0, 1, 2});
    mesh.triangle_materials.push_back(static_cast<std::uint32_t>(i));
    mesh.materials.push_back({std::string(i + 1, 'm'), {1, 1, {1, 2, 3, 255}}});
  }
  return mesh;
}

/// What is refused, or nothing.
std::string refusal(const ResultFiles& results, const InputFiles& inputs) {
  const CaughtError error = error_of([&] { require_separate_files(results, inputs); });
  CHECK((error.message.empty() || error.code == ErrorCode::invalid_argument));
  return error.message;
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Results may not overwrite what they are made from") {
  const TemporaryFolder folder;
  for (const char* name : {"camera.yml", "first.txt", "frames/000.png", "frames/001.png", "video.mp4"}) {
    fs::create_directories((folder / name).parent_path());
    folder.write(name, "x");
  }
  io::save_model(folder / "box.obj", textured_triangle(1));
  io::save_model(folder / "many.obj", textured_triangle(2));
  const std::string frames = (folder / "frames").string();
  const InputFiles inputs{{folder / "camera.yml", folder / "first.txt", {}}, {frames}, {folder / "box.obj"}};
  const auto file = [&](const char* name) { return ResultFiles{{folder / name, {}}, {}, {}}; };

  CHECK(refusal(file("poses.csv"), inputs).empty());
  for (const char* name : {"camera.yml", "frames/../first.txt", "box.obj", "box.mtl", "box.png"}) {
    CAPTURE(name);
    CHECK(says(refusal(file(name), inputs), "is an input and would be overwritten"));
  }
  CHECK(says(refusal(file("frames/000.png"), inputs), "would be one of the frames"));
  CHECK(says(refusal(file("frames/sheet.png"), inputs), "would be one of the frames"));
  CHECK(refusal(file("frames/poses.csv"), inputs).empty());
  CHECK(says(refusal(file("video.mp4"), {{}, {(folder / "video.mp4").string()}, {}}), "is an input"));
  CHECK(says(refusal(file("frames/001.png"), {{}, {(folder / "frames/%03d.png").string()}, {}}), "is an input"));
  CHECK(says(refusal(file("frames/001.png"), {{}, {(folder / "frames/*.png").string()}, {}}), "is an input"));
  CHECK(says(refusal({{}, {folder / "frames"}, {}}, inputs), "holds frames"));
  CHECK(refusal({{}, {folder / "plots", folder.path()}, {}}, inputs).empty());

  const auto model = [&](const char* name) { return ResultFiles{{}, {}, {folder / name}}; };
  CHECK(refusal(model("new.obj"), inputs).empty());
  CHECK(refusal(model("many.obj"), inputs).empty());
  CHECK(says(refusal(model("box.obj"), inputs), "is an input"));
  fs::rename(folder / "box.obj", folder / "scan.obj");  // its material file and texture are still box.mtl and box.png
  CHECK(says(refusal(model("box.obj"), {{}, {}, {folder / "scan.obj"}}), "is an input"));
  CHECK(says(refusal({{folder / "many_1.png"}, {}, {}}, {{}, {}, {folder / "many.obj"}}), "is an input"));
}

TEST_CASE("Results may not overwrite one another, but for devices") {
  const TemporaryFolder folder;
  CHECK(says(refusal({{folder / "a.csv", folder / "b/../a.csv"}, {}, {}}, {}), "two results"));
  CHECK(says(refusal({{folder / "a.obj"}, {}, {folder / "a.obj"}}, {}), "two results"));
  CHECK(refusal({{"/dev/null", "/dev/null"}, {}, {}}, {}).empty());
  // Not there yet, and spelled otherwise.
  const std::string none = "holdfast-none.csv";
  CHECK(says(refusal({{none, "./" + none}, {}, {}}, {}), "two results"));
  CHECK(says(refusal({{fs::current_path() / none, none}, {}, {}}, {}), "two results"));
}

TEST_CASE("No result takes the place of a file that a new model brings") {
  const TemporaryFolder folder;
  const auto beside = [&](const char* name) { return refusal({{folder / name}, {}, {folder / "a.obj"}}, {}); };
  for (const char* name : {"a.png", "a.mtl", "a_0.png", "a_12.png", "b/../a.png"}) {
    CAPTURE(std::string(name));
    CHECK(says(beside(name), "keeps its materials or texture"));
  }
  for (const char* name : {"a.csv", "a_.png", "a_x.png", "b/a.png", "ab.png", "a_0.jpg"}) {
    CAPTURE(std::string(name));
    CHECK(beside(name).empty());
  }
}

TEST_CASE("A model's files are those that it names") {
  const TemporaryFolder folder;
  io::save_model(folder / "many.obj", textured_triangle(3));
  const auto names = [](const std::vector<fs::path>& files) {
    std::vector<std::string> sorted;
    for (const fs::path& file : files) sorted.push_back(file.filename().string());
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  const std::vector<std::string> all{"many.mtl", "many.obj", "many_0.png", "many_1.png", "many_2.png"};
  CHECK(names(io::model_files(folder / "many.obj")) == all);
  CHECK(names(io::replaceable_model_files(folder / "many.obj")) == all);
  fs::remove(folder / "many_1.png");
  CHECK(names(io::model_files(folder / "many.obj")).size() == 4);
  CHECK(io::model_files(folder / "none.obj") == std::vector<fs::path>{folder / "none.obj"});
  CHECK(io::replaceable_model_files(folder / "man.obj").empty());
}
