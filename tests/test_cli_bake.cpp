#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "holdfast/io.hpp"
#include "support/files.hpp"
#include "support/run_program.hpp"
#include "support/small_sequence.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using namespace holdfast::app;
using namespace holdfast::test;

namespace {

constexpr int kFrames = 12;

/// A sequence of a box, and the box without its texture; names are relative to the folder that the program runs in.
class Inputs {
 public:
  Inputs() {
    const std::vector<Pose> truth = write_small_sequence(folder_, kFrames, 4);
    std::string poses;
    for (const Pose& pose : truth) {
      poses += line(pose);
    }
    folder_.write("poses.txt", poses);
    folder_.write("three.txt", line(truth[0]) + line(truth[5]) + line(truth[11]));
    Mesh plain = io::load_model(folder_ / "box.obj");
    plain.materials.clear();
    plain.triangle_materials.clear();
    plain.texture_coordinates.clear();
    io::save_model(folder_ / "plain.obj", plain);
    Pose off = truth[0];
    off.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, -1).normalized()));
    off.translation() += Eigen::Vector3d(0.003, -0.002, 0.004);
    io::save_pose(folder_ / "off.txt", off);
    Pose behind = truth[0];
    behind.translation().z() *= -1;
    io::save_pose(folder_ / "behind.txt", behind);
    cv::imwrite((folder_ / "small.png").string(), cv::Mat(120, 160, CV_8UC3, cv::Scalar(9, 9, 9)));
  }

  const TemporaryFolder& folder() const { return folder_; }
  static std::string frame(int i) { return "frames/" + std::to_string(i) + ".png"; }

  ProgramRun run(const Arguments& arguments) const { return run_holdfast(arguments, folder_); }

 private:
  static std::string line(const Pose& pose) {
    std::string text;
    for (int i = 0; i < 12; ++i) {
      text += std::to_string(pose.matrix()(i / 4, i % 4)) + (i == 11 ? "\n" : " ");
    }
    return text;
  }

  TemporaryFolder folder_;
};

const Inputs& inputs() {
  static const Inputs made;
  return made;
}

ProgramRun bake(const Arguments& more, const std::string& model = "plain.obj") {
  Arguments arguments{"bake", "--model", model, "--camera", "camera.yml"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return inputs().run(arguments);
}

/// Share of the texture's texels that are known.
double known_share(const std::string& model) {
  const Mesh mesh = io::load_model(inputs().folder() / model);
  REQUIRE(mesh.materials.size() == 1);
  REQUIRE(!mesh.texture_coordinates.empty());
  const Texture& texture = mesh.materials[0].texture;
  REQUIRE(!texture.empty());
  double known = 0;
  for (std::size_t i = 3; i < texture.rgba.size(); i += 4) {
    known += texture.rgba[i] == 255 ? 1 : 0;
  }
  return known / (static_cast<double>(texture.rgba.size()) / 4);
}

void check_fails(int exit_code, const Arguments& more, const std::vector<std::string>& words,
                 const std::string& model = "plain.obj") {
  check_error(bake(more, model), exit_code, words);
}

/// The number before `unit` on the line of `text` that holds it first.
double number_before(const std::string& text, const std::string& unit) {
  const std::size_t end = text.find(unit);
  REQUIRE(end != std::string::npos);
  const std::size_t begin = text.find_last_of(" \n", end - 2);
  return std::stod(text.substr(begin == std::string::npos ? 0 : begin + 1));
}

}  // namespace

TEST_CASE("bake: a sequence and its first pose give a model that can be tracked") {
  const ProgramRun run = bake({"frames", "--init", "first.txt", "--out", "baked.obj"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == kOk);
  CHECK(number_before(run.err, " mm and ") < 3);
  CHECK(run.out.find("of 12 frames") != std::string::npos);
  CHECK(run.out.find("baked.obj") != std::string::npos);
  CHECK(number_before(run.out, " % of the surface") > 25);
  CHECK(known_share("baked.obj") > 0.2);

  const ProgramRun tracked = inputs().run({"track", "frames", "--model", "baked.obj", "--camera", "camera.yml",
                                           "--init", "first.txt", "--require-held", "--poses", "baked.csv"});
  CAPTURE(tracked.err);
  CHECK(tracked.exit_code == kOk);
  const ProgramRun judged =
      inputs().run({"evaluate", "--poses", "baked.csv", "--truth", "poses.txt", "--json", "baked.json"});
  CAPTURE(judged.out);
  CHECK(judged.exit_code == kOk);
  CHECK(judged.out.find("100.0") != std::string::npos);
}

TEST_CASE("bake: a first pose that is off is not baked in, unless it is to be kept; another shape is warned of") {
  const Pose T_true = io::load_poses(inputs().folder() / "poses.txt").front();
  const auto error_of = [&](const Arguments& more) {
    Arguments arguments{"frames", "--init", "off.txt", "--out", "off.obj"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    REQUIRE(bake(arguments).exit_code == kOk);
    REQUIRE(inputs()
                .run({"track", "frames", "--model", "off.obj", "--camera", "camera.yml", "--init", "off.txt", "--tum",
                      "off.tum", "--stop", "1", "--quiet"})
                .exit_code == kOk);
    return (io::load_poses(inputs().folder() / "off.tum").front().translation() - T_true.translation()).norm();
  };
  const double aligned = error_of({}), kept = error_of({"--keep-pose"});
  CAPTURE(aligned);
  CAPTURE(kept);
  CHECK(kept > 0.003);
  CHECK(aligned < kept / 2);

  Mesh taller = io::load_model(inputs().folder() / "plain.obj");
  for (Eigen::Vector3f& position : taller.positions) position.y() *= 2;
  io::save_model(inputs().folder() / "taller.obj", taller);
  const ProgramRun other = bake({"frames", "--init", "first.txt", "--out", "other.obj", "--stop", "1"}, "taller.obj");
  CHECK(other.err.find("outline is not clear") != std::string::npos);
}

TEST_CASE("bake: one image, several images with a pose each, a sequence with the poses that track wrote") {
  SUBCASE("one image") {
    const ProgramRun run = bake({Inputs::frame(0), "--init", "first.txt", "--out", "one.obj"});
    CAPTURE(run.err);
    CHECK(run.exit_code == kOk);
    CHECK(known_share("one.obj") > 0.2);
  }
  SUBCASE("one image, without the contour") {
    for (const char* option : {"--no-contour", "--mode=paper"}) {
      const ProgramRun run = bake({Inputs::frame(0), "--init", "first.txt", "--out", "one.obj", option});
      CAPTURE(run.err);
      CHECK(run.exit_code == kOk);
    }
  }
  SUBCASE("three images") {
    const ProgramRun run =
        bake({Inputs::frame(0), Inputs::frame(5), Inputs::frame(11), "--poses", "three.txt", "--out", "three.obj"});
    CAPTURE(run.err);
    CHECK(run.exit_code == kOk);
    CHECK(run.out.find("3 of 3 frames") != std::string::npos);
    CHECK(known_share("three.obj") > 0.2);
  }
  SUBCASE("a table of poses; lost frames are left out") {
    const ProgramRun tracked = inputs().run({"track", "frames", "--model", "box.obj", "--camera", "camera.yml",
                                             "--init", "first.txt", "--poses", "table.csv", "--quiet"});
    REQUIRE(tracked.exit_code == kOk);
    std::string table = read_file(inputs().folder() / "table.csv");
    const std::size_t last_held = table.rfind(",held,");
    REQUIRE(last_held != std::string::npos);
    table.replace(last_held, 6, ",lost,");
    inputs().folder().write("table.csv", table);
    const ProgramRun run = bake({"frames", "--poses", "table.csv", "--every", "1", "--out", "table.obj"});
    CAPTURE(run.err);
    CHECK(run.exit_code == kOk);
    CHECK(run.out.find("11 of 11 frames") != std::string::npos);
    CHECK(known_share("table.obj") > 0.2);
  }
}

TEST_CASE("bake: coordinates that the model has stay, unless it is to be unwrapped; resolution is as asked for") {
  const Mesh given = io::load_model(inputs().folder() / "box.obj");
  REQUIRE(bake({Inputs::frame(0), "--init", "first.txt", "--out", "kept.obj"}, "box.obj").exit_code == kOk);
  const Mesh kept = io::load_model(inputs().folder() / "kept.obj");
  REQUIRE(kept.texture_coordinates.size() == given.texture_coordinates.size());
  float largest = 0;
  for (std::size_t i = 0; i < kept.texture_coordinates.size(); ++i) {
    largest = std::max(largest, (kept.texture_coordinates[i] - given.texture_coordinates[i]).cwiseAbs().maxCoeff());
  }
  CHECK(largest < 1e-5F);

  REQUIRE(bake({Inputs::frame(0), "--init", "first.txt", "--out", "new.obj", "--unwrap", "--texels-per-metre", "500"},
               "box.obj")
              .exit_code == kOk);
  const Mesh unwrapped = io::load_model(inputs().folder() / "new.obj");
  double texels = 0;
  double surface = 0;
  for (const auto& [a, b, c] : unwrapped.triangles) {
    const auto& p = unwrapped.positions;
    const auto& t = unwrapped.texture_coordinates;
    const Eigen::Vector2f u = t[b] - t[a];
    const Eigen::Vector2f v = t[c] - t[a];
    surface += 0.5 * static_cast<double>((p[b] - p[a]).cross(p[c] - p[a]).norm());
    texels += 0.5 * std::abs(static_cast<double>(u.x() * v.y() - u.y() * v.x())) *
              unwrapped.materials[0].texture.width * unwrapped.materials[0].texture.height;
  }
  CHECK(std::sqrt(texels / surface) == doctest::Approx(500).epsilon(0.01));
}

TEST_CASE("bake: bad input is one line that says what to do") {
  const Arguments fine{"frames", "--init", "first.txt", "--out", "fine.obj"};
  check_fails(kUsage, {"frames", "--out", "x.obj"}, {"--init", "--poses"});
  check_fails(kUsage, {"frames", "--init", "first.txt", "--poses", "poses.txt", "--out", "x.obj"},
              {"--init", "--poses"});
  check_fails(kUsage, {Inputs::frame(0), Inputs::frame(1), "--init", "first.txt", "--out", "x.obj"},
              {"several inputs", "--poses"});
  check_fails(kUsage, {"frames", "--init", "first.txt", "--out", "x.ply"}, {"x.ply", ".obj"});
  check_fails(kUsage, {"frames", "--init", "first.txt", "--out", "plain.obj"}, {"plain.obj", "overwritten"});
  check_fails(kOutput, {"frames", "--init", "first.txt", "--out", "nowhere/x.obj"}, {"nowhere"});
  check_fails(kInput, {"frames", "--init", "behind.txt", "--out", "x.obj"}, {"behind the camera"});
  check_fails(kInput, {"missing", "--init", "first.txt", "--out", "x.obj"}, {"missing"});
  check_fails(kInput, {Inputs::frame(0), Inputs::frame(1), "--poses", "three.txt", "--out", "x.obj"},
              {"3 poses", "2 inputs"});
  check_fails(kInput, {Inputs::frame(0), "small.png", Inputs::frame(1), "--poses", "three.txt", "--out", "x.obj"},
              {"small.png", "160x120", "320x240"});
  check_fails(kInput, fine, {"missing.obj"}, "missing.obj");
  CHECK_FALSE(fs::exists(inputs().folder() / "x.obj"));
}

TEST_CASE("track --complete-model: a model without a texture is tracked, and written with one") {
  const ProgramRun run =
      inputs().run({"track", "frames", "--model", "plain.obj", "--camera", "camera.yml", "--init", "first.txt",
                    "--complete-model", "completed.obj", "--require-held", "--poses", "completed.csv"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.out.find("12 held") != std::string::npos);
  CHECK(run.out.find("of the surface known") != std::string::npos);
  CHECK(known_share("completed.obj") > 0.2);
  const ProgramRun again = inputs().run({"track", "frames", "--model", "completed.obj", "--camera", "camera.yml",
                                         "--init", "first.txt", "--complete-model", "again.obj", "--quiet"});
  CHECK(again.exit_code == kOk);
  CHECK(known_share("again.obj") >= known_share("completed.obj"));

  const ProgramRun wrong = inputs().run({"track", "frames", "--model", "plain.obj", "--camera", "camera.yml", "--init",
                                         "first.txt", "--complete-model", "plain.obj"});
  CHECK(wrong.exit_code == kUsage);
  CHECK(wrong.err.find("overwritten") != std::string::npos);
}

TEST_CASE("evaluate --marks: distances between marked points and where poses put them") {
  // One corner, marked 3 px right and 4 px below where the true poses of frames 0 and 2 put it.
  const std::vector<Pose> poses = io::load_poses(inputs().folder() / "poses.txt");
  const Camera camera = io::load_camera(inputs().folder() / "camera.yml");
  const Eigen::Vector3d corner(0.1, 0.075, 0.04);
  std::string marks = "# frame,x,y,z,u,v\n";
  for (const int frame : {0, 2}) {
    const Eigen::Vector2d pixel = camera.project(poses[static_cast<std::size_t>(frame)] * corner);
    marks += std::to_string(frame) + ",0.1,0.075,0.04," + std::to_string(pixel.x() + 3) + "," +
             std::to_string(pixel.y() + 4) + "\n";
  }
  inputs().folder().write("marks.csv", marks);
  const Arguments arguments{"evaluate", "--poses", "poses.txt", "--camera", "camera.yml", "--marks"};
  const auto evaluate = [&](const std::string& file) {
    Arguments all = arguments;
    all.push_back(file);
    return inputs().run(all);
  };
  const ProgramRun run = evaluate("marks.csv");
  CAPTURE(run.out);
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.out.find("    0  held      5.0\n    2  held      5.0\n") != std::string::npos);
  CHECK(run.out.find("2 points: median 5.00, 95 % 5.00, largest 5.00 pixels") != std::string::npos);

  const auto within = [&](const std::string& bounds) {
    Arguments all = arguments;
    all.insert(all.end(), {"marks.csv", "--within", bounds});
    return inputs().run(all).exit_code;
  };
  CHECK(within("5.1,5.1") == kOk);
  CHECK(within("4.9,5.1") == kLost);
  CHECK(within("5.1,4.9") == kLost);

  inputs().folder().write("far.csv", "77,0,0,0,1,1\n");
  CHECK(evaluate("far.csv").exit_code == kInput);
  CHECK(evaluate("far.csv").err.find("frame 77") != std::string::npos);
  inputs().folder().write("short.csv", "1,2,3\n");
  CHECK(evaluate("short.csv").err.find("short.csv, line 1") != std::string::npos);
  CHECK(evaluate("missing.csv").exit_code == kInput);
  CHECK(inputs().run({"evaluate", "--marks", "marks.csv"}).exit_code == kUsage);
}
