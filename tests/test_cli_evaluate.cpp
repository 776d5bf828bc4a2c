// `holdfast simulate` and `holdfast evaluate` as programs: what one writes the other measures, and what is wrong with
// the input is said in one line.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "holdfast/io.hpp"
#include "support/files.hpp"
#include "support/run_program.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using holdfast::test::Arguments;
using holdfast::test::ProgramRun;
using holdfast::test::read_file;
using holdfast::test::run_holdfast;
using holdfast::test::TemporaryFolder;

namespace {

/// Twelve frames of a box with a wide bar before it, made once; names are relative to the folder programs run in.
class Simulated {
 public:
  Simulated() {
    const ProgramRun run =
        this->run({"simulate",    "sequence", "--frames",     "12", "--size",  "320x240", "--samples",  "2",
                   "--motion",    "sharp",    "--turns",      "1",  "--speed", "2",       "--occluder", "bar",
                   "--bar-width", "60",       "--bar-sweeps", "1",  "--masks", "--quiet"});
    REQUIRE(run.exit_code == app::kOk);
  }
  ProgramRun run(const Arguments& arguments) const { return run_holdfast(arguments, folder_); }
  fs::path operator/(const std::string& name) const { return folder_ / name; }

  /// A copy of the sequence to spoil.
  fs::path copy(const std::string& name) const {
    fs::remove_all(folder_ / name);
    fs::copy(folder_ / "sequence", folder_ / name, fs::copy_options::recursive);
    return folder_ / name;
  }

 private:
  TemporaryFolder folder_;
};

const Simulated& simulated() {
  static const Simulated made;
  return made;
}

nlohmann::json summary_of(const std::string& report) {
  return nlohmann::json::parse(read_file(simulated() / report))["evaluations"].at(0)["summary"];
}

/// The estimated poses of a table of frames.
std::vector<std::string> estimates(const std::string& table) {
  std::ifstream in(simulated() / table);
  std::vector<std::string> out;
  std::string line;
  while (std::getline(in, line)) {
    std::size_t from = line.size();
    for (int column = 0; column < 12; ++column) {
      from = line.rfind(',', from - 1);
    }
    out.push_back(line.substr(from));
  }
  return out;
}

/// The lines of a table, all but the column of this name.
std::vector<std::string> without_column(const std::string& table, const std::string& name) {
  std::ifstream in(simulated() / table);
  std::vector<std::string> out;
  std::string line;
  std::ptrdiff_t left_out = -1;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::string cell, kept;
    for (std::ptrdiff_t column = 0; std::getline(cells, cell, ','); ++column) {
      if (out.empty() && cell == name) left_out = column;
      if (column != left_out) kept += cell + ',';
    }
    out.push_back(kept);
  }
  CHECK(left_out >= 0);
  return out;
}

void check_fails(const Arguments& arguments, int exit_code, const std::vector<std::string>& words) {
  test::check_error(simulated().run(arguments), exit_code, words);
}

void append(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::app) << text; }

}  // namespace

TEST_CASE("Pixels used on the occluder are counted, and looking at them or drawing them changes no pose") {
  const Arguments common = {"evaluate", "sequence", "--model", "sequence/model/model.obj", "--quiet"};
  const auto evaluate = [&](const Arguments& more) {
    Arguments arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = simulated().run(arguments);
    CAPTURE(run.err);
    REQUIRE(run.exit_code == app::kOk);
    return run;
  };
  const ProgramRun on =
      evaluate({"--json", "on.json", "--csv", "on.csv", "--pictures", "drawn", "--picture-frames", "0,6", "--details"});
  CHECK(on.out.find("occluder%") != std::string::npos);
  evaluate({"--json", "off.json", "--no-gradient-test", "--no-angle-test", "--no-magnitude-test", "--no-block-vote"});
  const auto rejected = summary_of("on.json")["occluder_pixels_used"];
  const auto everything = summary_of("off.json")["occluder_pixels_used"];
  REQUIRE(rejected.is_object());
  REQUIRE(everything.is_object());
  CHECK(rejected["frames"].get<int>() >= 4);
  CHECK(rejected["share"].get<double>() < 0.005);
  // The bar hides a quarter of the box and more in the middle: without tests its pixels are used like any others.
  CHECK(everything["worst_frame"].get<double>() > 0.1);
  CHECK(everything["worst_frame"].get<double>() >= everything["share"].get<double>());

  CHECK(fs::exists(simulated() / "drawn/sequence_step1_000000.png"));
  CHECK(fs::exists(simulated() / "drawn/sequence_step1_000006.png"));
  CHECK(std::distance(fs::directory_iterator(simulated() / "drawn"), {}) == 2);

  // Another folder of the same name: results of its own.
  fs::create_directory(simulated() / "again");
  simulated().copy("again/sequence");
  evaluate({"again/sequence", "--json", "two.json", "--pictures", "drawn2", "--picture-frames", "0"});
  const nlohmann::json two = nlohmann::json::parse(read_file(simulated() / "two.json"))["evaluations"];
  CHECK(two.at(0)["sequence"] != two.at(1)["sequence"]);
  CHECK(two.at(1)["sequence"] == "again_sequence");
  CHECK(fs::exists(simulated() / "drawn2/again_sequence_step1_000000.png"));
  CHECK(std::distance(fs::directory_iterator(simulated() / "drawn2"), {}) == 2);

  simulated().copy("unmasked");
  fs::remove_all(simulated() / "unmasked/masks");
  const ProgramRun plain = simulated().run({"evaluate", "unmasked", "--model", "sequence/model/model.obj", "--quiet",
                                            "--json", "plain.json", "--csv", "plain.csv"});
  REQUIRE(plain.exit_code == app::kOk);
  CHECK(summary_of("plain.json")["occluder_pixels_used"].is_null());
  CHECK(estimates("plain.csv") == estimates("on.csv"));
  CHECK(estimates("plain.csv").size() == 13);
}

TEST_CASE("Two runs track to the same poses and figures, to the last digit") {
  const std::string truth = read_file(simulated() / "sequence/poses_gt.txt");
  std::ofstream(simulated() / "first.txt") << truth.substr(0, truth.find('\n') + 1);
  const auto tracked = [&](const std::string& table) {
    const ProgramRun run =
        simulated().run({"track", "sequence/frames", "--model", "sequence/model/model.obj", "--camera",
                         "sequence/K.txt", "--init", "first.txt", "--poses", table, "--quiet"});
    CAPTURE(run.err);
    REQUIRE(run.exit_code == app::kOk);
    return without_column(table, "ms");
  };
  const std::vector<std::string> once = tracked("once.csv");
  CHECK(once.size() == 13);
  CHECK(once == tracked("again.csv"));
  // Judged afterwards, the folder's own model is taken as well.
  const ProgramRun compared =
      simulated().run({"evaluate", "sequence", "--poses", "once.csv", "--json", "compared.json", "--quiet"});
  CAPTURE(compared.err);
  REQUIRE(compared.exit_code == app::kOk);
  CHECK(summary_of("compared.json")["add"]["below_10_percent"] == 1);

  const auto judged = [&](const std::string& folder, const std::string& table) {
    const ProgramRun run =
        simulated().run({"evaluate", folder, "--protocol", "starts", "--starts", "3", "--start-frames", "2", "--csv",
                         table, "--quiet"});  // the model is the folder's own
    CAPTURE(run.err);
    REQUIRE(run.exit_code == app::kOk);
    return estimates(table);
  };
  const std::vector<std::string> starts = judged("sequence", "starts.csv");
  CHECK(starts.size() == 4);
  CHECK(starts == judged("sequence", "starts-again.csv"));
  // A calibration beside K.txt counts: K.txt has no room for a lens.
  const fs::path spoilt = simulated().copy("spoilt");
  io::save_camera(spoilt / "camera.yml", io::camera_for_frames(io::load_camera(spoilt / "K.txt"), 320, 240, false));
  std::ofstream(spoilt / "K.txt") << "100 100 10 10\n";
  CHECK(starts == judged("spoilt", "starts-spoilt.csv"));
}

TEST_CASE("A BOP scene is the sequence that it was made of, its model found below the data set") {
  const fs::path scene = simulated() / "bop/test/000001";
  const fs::path models = simulated() / "bop/models";
  fs::create_directories(scene / "rgb");
  fs::create_directories(models);
  std::ifstream camera(simulated() / "sequence/K.txt");
  std::array<double, 4> k;
  for (double& number : k) camera >> number;
  std::ifstream poses(simulated() / "sequence/poses_gt.txt");
  nlohmann::json truth, cameras;
  for (int i = 0; i < 12; ++i) {
    std::vector<double> rotation, translation;
    for (int j = 0; j < 12; ++j) {
      double number = 0;
      poses >> number;
      if (j % 4 == 3) {
        translation.push_back(1000 * number);
      } else {
        rotation.push_back(number);
      }
    }
    const std::string image = std::to_string(i);
    truth[image] = {{{"cam_R_m2c", rotation}, {"cam_t_m2c", translation}, {"obj_id", 7}}};
    cameras[image] = {{"cam_K", {k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1}}};
    const std::string name = (i < 10 ? "00000" : "0000") + image + ".png";
    fs::copy_file(simulated() / "sequence/frames" / name, scene / "rgb" / name);
  }
  std::ofstream(scene / "scene_gt.json") << truth;
  std::ofstream(scene / "scene_camera.json") << cameras;

  // BOP's own kind of model: PLY with texture coordinates at the vertices, in millimetres.
  const Mesh mesh = io::load_model(simulated() / "sequence/model/model.obj");
  fs::copy_file(simulated() / "sequence/model/model.png", models / "obj_000007.png");
  std::ofstream ply(models / "obj_000007.ply");
  ply << "ply\nformat ascii 1.0\ncomment TextureFile obj_000007.png\nelement vertex " << mesh.positions.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty float texture_u\nproperty float texture_v\n"
      << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3f p = 1000 * mesh.positions[i];
    // v from the bottom of the picture upwards in the file, as in OBJ.
    ply << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << mesh.texture_coordinates[i].x() << ' '
        << mesh.texture_coordinates[i].y() << '\n';
  }
  for (const auto& triangle : mesh.triangles) {
    ply << "3 " << triangle[0] << ' ' << triangle[1] << ' ' << triangle[2] << '\n';
  }
  ply.close();

  const ProgramRun bop = simulated().run({"evaluate", "bop/test/000001", "--quiet", "--json", "bop.json"});
  CAPTURE(bop.err);
  REQUIRE(bop.exit_code == app::kOk);
  const nlohmann::json summary = summary_of("bop.json");
  CHECK(summary["frames"] == 12);
  CHECK(summary["within_20mm_2deg"]["share"] == 1.0);
  CHECK(summary["translation_mm"]["max"].get<double>() < 2);
  CHECK(summary["rotation_deg"]["max"].get<double>() < 0.5);
  const nlohmann::json report = nlohmann::json::parse(read_file(simulated() / "bop.json"));
  CHECK(report["evaluations"].at(0)["diameter_mm"].get<double>() == doctest::Approx(262.5).epsilon(0.01));
}

TEST_CASE("The model that an older sequence left in its folder is pointed out") {
  simulated().copy("older");
  const Arguments again = {"simulate", "older",   "--overwrite", "--frames", "1",
                           "--size",   "160x120", "--quiet",     "--model"};
  const auto said = [&](const std::string& model) {
    Arguments arguments = again;
    arguments.push_back(model);
    const ProgramRun run = simulated().run(arguments);
    CHECK(run.exit_code == app::kOk);
    return run.err;
  };
  CHECK(said("sequence/model/model.obj").find("older/model/model.obj is an older sequence's") != std::string::npos);
  CHECK(said("older/model/model.obj").empty());
}

TEST_CASE("Bad sequences and models: one line each, before any frame is tracked") {
  const Arguments model = {"--model", "sequence/model/model.obj"};
  const auto evaluate = [&](const std::string& folder) { return Arguments{"evaluate", folder, model[0], model[1]}; };
  SUBCASE("an empty folder") {
    fs::create_directories(simulated() / "empty");
    check_fails(evaluate("empty"), app::kInput, {"empty", "poses_gt.txt"});
  }
  SUBCASE("no folder") { check_fails(evaluate("none"), app::kInput, {"none", "no such folder"}); }
  SUBCASE("a frame missing") {
    fs::remove(simulated().copy("spoiled") / "frames/000007.png");
    check_fails(evaluate("spoiled"), app::kInput, {"11 frames but 12 true poses"});
  }
  SUBCASE("a frame of another size") {
    const fs::path frame = simulated().copy("spoiled") / "frames/000002.png";
    cv::imwrite(frame.string(), cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(0)));
    check_fails(evaluate("spoiled"), app::kInput, {"000002.png", "32x24", "320x240"});
  }
  SUBCASE("a light that circles in no time") {
    check_fails({"simulate", "new", "--light-orbit", "0.5,0"}, app::kUsage, {"--light-orbit"});
  }
  SUBCASE("a mask missing") {
    fs::remove(simulated().copy("spoiled") / "masks/000007.png");
    check_fails(evaluate("spoiled"), app::kInput, {"11 images but 12 true poses"});
  }
  SUBCASE("a pose too many, which is no rotation either") {
    append(simulated().copy("spoiled") / "poses_gt.txt", "1 0 0 0 0 1 0 0 0 0 1.1 0.5\n");
    check_fails(evaluate("spoiled"), app::kInput, {"poses_gt.txt", "line 13"});
  }
  SUBCASE("a share missing") {
    append(simulated().copy("spoiled") / "visible.txt", "1\n");
    check_fails(evaluate("spoiled"), app::kInput, {"13 visible shares but 12 true poses"});
  }
  SUBCASE("no model") {
    check_fails({"evaluate", "sequence", "--model", "none.obj"}, app::kInput, {"none.obj"});
    fs::remove_all(simulated().copy("spoiled") / "model");
    check_fails({"evaluate", "spoiled"}, app::kUsage, {"'spoiled' has no model/model.obj", "--model"});
    check_fails({"simulate", "new", "--model", "none.obj"}, app::kInput, {"none.obj"});
  }
  SUBCASE("an occluder without path, or with a bad one") {
    check_fails({"simulate", "new", "--occluder-model", "box"}, app::kUsage, {"--occluder-trajectory"});
    append(simulated() / "short.txt", "1 0 0 0 0 1 0 0 0 0 1 2\n1 0 0 0 0 1 0 0 0 0 1 2\n");
    check_fails({"simulate", "new", "--frames", "3", "--occluder-model", "box", "--occluder-trajectory", "short.txt"},
                app::kInput, {"short.txt: 2 poses for 3 frames"});
    check_fails({"simulate", "new", "--frames", "3", "--trajectory", "short.txt"}, app::kInput,
                {"short.txt: 2 poses for 3 frames"});
    append(simulated() / "bad.txt", "1 0 0 0 0 1 0 0 0 0 2 0.5\n");
    check_fails({"simulate", "new", "--trajectory", "bad.txt"}, app::kInput, {"bad.txt", "line 1"});
  }
  SUBCASE("results where the input is") {
    for (const std::string file : {"sequence/poses_gt.txt", "sequence/K.txt", "sequence/visible.txt",
                                   "sequence/model/model.obj", "sequence/model/model.png"}) {
      check_fails({"evaluate", "sequence", model[0], model[1], "--csv", file}, app::kUsage, {file, "is an input"});
    }
    check_fails({"evaluate", "sequence", "--poses", "sequence/poses_gt.txt", "--json", "sequence/poses_gt.txt"},
                app::kUsage, {"sequence/poses_gt.txt", "is an input"});
    check_fails({"evaluate", "sequence", model[0], model[1], "--pictures", "sequence/frames", "--picture-frames", "1"},
                app::kUsage, {"sequence/frames", "holds frames"});
  }
  SUBCASE("pictures without frames, or where none can be written") {
    check_fails({"evaluate", "sequence", model[0], model[1], "--pictures", "drawn"}, app::kUsage, {"--picture-frames"});
    check_fails({"evaluate", "sequence", model[0], model[1], "--pictures", "drawn", "--picture-frames", "3,12"},
                app::kUsage, {"--picture-frames 12"});
    append(simulated() / "file", "a file");
    check_fails({"evaluate", "sequence", model[0], model[1], "--pictures", "file/drawn", "--picture-frames", "1"},
                app::kOutput, {"file/drawn"});
  }
}
