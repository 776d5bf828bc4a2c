// `holdfast track` without a first pose: found, found in vain, found again, views on disk.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "holdfast/io.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"
#include "support/paper_box.hpp"
#include "support/run_program.hpp"
#include "support/simulated.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using namespace holdfast::app;
using namespace holdfast::test;

namespace {

struct Row {
  std::string status;
  Pose T_camera_object = Pose::Identity();
};

std::vector<Row> rows_of(const fs::path& csv) {
  std::ifstream file(csv);
  std::vector<Row> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::vector<std::string> words;
    for (std::string word; words.size() < 10 && std::getline(fields, word, ',');) words.push_back(word);
    REQUIRE(words.size() == 10);
    const auto number = [&](std::size_t i) { return std::stod(words[i]); };
    Row row;
    row.status = words[2];
    row.T_camera_object.translation() << number(3), number(4), number(5);
    row.T_camera_object.linear() =
        Eigen::Quaterniond(number(9), number(6), number(7), number(8)).normalized().toRotationMatrix();
    rows.push_back(row);
  }
  return rows;
}

/// Five frames of the box, six of anything else, ten of the box turned round and elsewhere.
class Scene {
 public:
  static constexpr int kFirst = 5, kAway = 6, kBack = 10;

  Scene() {
    const Mesh mesh = simulation::textured_box();
    simulation::SequenceOptions options = noisy_box(kFirst + kBack, 5, 0.5, 0.9);
    Pose T = Pose::Identity();
    T.linear() = simulation::MotionOptions::default_orientation();
    T.translation() << 0.03, 0.02, 0.7;
    Pose T_back = T;
    T_back.linear() = T.linear() * Eigen::AngleAxisd(2.4, Eigen::Vector3d(0.1, 1, 0.2).normalized());
    T_back.translation() << -0.1, -0.05, 0.65;
    for (int i = 0; i < kFirst + kBack; ++i) {
      Pose pose = i < kFirst ? T : T_back;
      pose.translation().x() += 0.003 * i;
      poses.push_back(pose);
    }
    options.motion.T_camera_object = poses;
    const simulation::Sequence sequence(mesh, options);
    fs::create_directory(folder / "frames");
    fs::create_directory(folder / "empty");
    const cv::Mat away = clutter(options.camera);
    int number = 0;
    const auto write = [&](const char* name, const cv::Mat& frame) {
      std::string digits = std::to_string(number);
      cv::imwrite((folder / name / (digits + ".png")).string(), frame);
    };
    for (int i = 0; i < kFirst + kBack; ++i) {
      if (i == kFirst) {
        for (int k = 0; k < kAway; ++k, ++number) {
          write("frames", away);
          write("empty", away);
        }
      }
      write("frames", sequence.frame(i));
      ++number;
    }
    io::save_model(folder / "box.obj", mesh);
    io::save_camera(folder / "camera.yml", options.camera);
    io::save_pose(folder / "first.txt", poses[0]);
    Mesh plain = mesh;
    plain.materials.clear();
    plain.texture_coordinates.clear();
    io::save_model(folder / "plain.obj", plain);
    options.frames = kFirst;
    options.motion.T_camera_object.resize(kFirst);
    const simulation::Sequence bare(simulation::plain_box({0.2, 0.15, 0.08}, {200, 60, 40}), options);
    fs::create_directory(folder / "bare");
    for (int i = 0; i < kFirst; ++i)
      cv::imwrite((folder / ("bare/" + std::to_string(i) + ".png")).string(), bare.frame(i));
  }

  ProgramRun track(const std::string& input, const std::string& model, Arguments more,
                   const Environment& environment = {}) const {
    Arguments arguments{"track", input, "--model", model, "--camera", "camera.yml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_holdfast(arguments, folder, environment);
  }

  TemporaryFolder folder;
  std::vector<Pose> poses;  ///< of the frames that show the box
};

const Scene& scene() {
  static const Scene made;
  return made;
}

void check_near(const Pose& T_true, const Pose& T) {
  const PoseError error = pose_error(T_true, T);
  CHECK(error.millimetres < 2);
  CHECK(error.degrees < 1);
}

}  // namespace

TEST_CASE("A first pose upon the outline, but upside down, is said to be that") {
  Pose turned = scene().poses[0];
  turned.linear() = Eigen::Vector3d(-1, -1, 1).asDiagonal() * turned.linear();
  io::save_pose(scene().folder / "turned.txt", turned);
  const auto said = [](const char* pose) {
    return scene().track("frames", "box.obj", {"--init", pose, "--stop", "2", "--quiet", "--poses", "t.csv"}).err;
  };
  CHECK(said("turned.txt").find("found if that is read upside down") != std::string::npos);
  CHECK(said("first.txt").empty());
}

TEST_CASE("Without a first pose the box is found in the first frame, and found again after it turned round") {
  const ProgramRun run = scene().track("frames", "box.obj", {"--poses", "poses.csv"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("looking for the object") != std::string::npos);
  CHECK(run.err.find("found in frame 0") != std::string::npos);
  const std::vector<Row> rows = rows_of(scene().folder / "poses.csv");
  REQUIRE(rows.size() == Scene::kFirst + Scene::kAway + Scene::kBack);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CAPTURE(i);
    const bool away = i >= Scene::kFirst && i < Scene::kFirst + Scene::kAway;
    if (away) {
      CHECK(rows[i].status == "lost");
    } else if (i < Scene::kFirst) {
      CHECK(rows[i].status == "held");
      check_near(scene().poses[i], rows[i].T_camera_object);
    } else if (rows[i].status == "held") {
      check_near(scene().poses[i - Scene::kAway], rows[i].T_camera_object);
    }
  }
  for (std::size_t i = rows.size() - 6; i < rows.size(); ++i) CHECK(rows[i].status == "held");
}

TEST_CASE("With a first pose nothing is said, and the box is found again too") {
  const ProgramRun run =
      scene().track("frames", "box.obj", {"--init", "first.txt", "--poses", "given.csv", "--overlay", "given.mp4"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.empty());
  const std::vector<Row> rows = rows_of(scene().folder / "given.csv");
  for (std::size_t i = rows.size() - 6; i < rows.size(); ++i) {
    CHECK(rows[i].status == "held");
    check_near(scene().poses[i - Scene::kAway], rows[i].T_camera_object);
  }
  // No search, no finding: that it is the search that finds it, not the tracker's own.
  CHECK(scene().track("frames", "box.obj", {"--init", "first.txt", "--poses", "none.csv", "--no-recovery"}).exit_code ==
        kOk);
  CHECK(rows_of(scene().folder / "none.csv").back().status == "lost");
}

TEST_CASE("A video that never shows the object ends as lost, after so many frames") {
  const ProgramRun run = scene().track("empty", "box.obj", {"--poses", "empty.csv", "--overlay", "empty.mp4"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kLost);
  CHECK(run.err.find("not found in any of 6 frames") != std::string::npos);
  for (const Row& row : rows_of(scene().folder / "empty.csv")) CHECK(row.status == "lost");
}

TEST_CASE("A model without texture needs a first pose or a guide") {
  check_error(scene().track("frames", "plain.obj", {}), kInput, {"neither texture nor vertex colours", "guide"});
}

TEST_CASE("Views are kept in the file that is named, which must be the model's and whole") {
  const auto track = [](const std::string& views) {
    return scene().track("frames", "box.obj", {"--stop", "2", "--quiet", "--views", views});
  };
  CHECK(track("box.views").exit_code == kOk);
  const std::string whole = read_file(scene().folder / "box.views");
  CHECK(whole.starts_with("holdfast features"));
  CHECK(track("box.views").exit_code == kOk);
  CHECK(read_file(scene().folder / "box.views") == whole);
  scene().folder.write("half.views", whole.substr(0, whole.size() / 2));
  check_error(track("half.views"), kInput, {"half.views", "damaged"});
  check_error(track("box.obj"), kInput, {"box.obj", "no file of views"});
  check_error(track("nowhere/box.views"), kOutput, {"nowhere/box.views"});
}

TEST_CASE("Views in the cache that are damaged are made again") {
  fs::create_directory(scene().folder / "cache");
  const Environment environment{{"HOLDFAST_CACHE_DIR", (scene().folder / "cache").string()}};
  const auto kept = [] {
    for (const auto& entry : fs::directory_iterator(scene().folder / "cache")) {
      if (entry.path().extension() == ".views") return entry.path();
    }
    return fs::path();
  };
  CHECK(scene().track("frames", "box.obj", {"--stop", "1", "--quiet"}, environment).exit_code == kOk);
  REQUIRE_FALSE(kept().empty());
  const std::string whole = read_file(kept());
  fs::resize_file(kept(), 1000);
  CHECK(scene().track("frames", "box.obj", {"--stop", "1", "--quiet"}, environment).exit_code == kOk);
  CHECK(read_file(kept()) == whole);
}

TEST_CASE("What a run remembers of a model without texture starts the next one without a pose") {
  const auto track = [](const std::string& model, const std::string& remembered, Arguments more = {}) {
    more.insert(more.end(), {"--stop", "5", "--remember", remembered, "--poses", "remembered.csv"});
    return scene().track("frames", model, more);
  };
  check_error(track("plain.obj", "box.seen"), kInput,
              {"neither texture nor vertex colours", "'box.seen' does not exist"});
  CHECK_FALSE(fs::exists(scene().folder / "box.seen"));
  CHECK(track("plain.obj", "box.seen", {"--init", "first.txt"}).exit_code == kOk);
  const std::string whole = read_file(scene().folder / "box.seen");
  CHECK(whole.size() > 1000);
  CHECK(whole.size() < 200000);
  const ProgramRun run = track("plain.obj", "box.seen");
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("found in frame 0") != std::string::npos);
  CHECK(read_file(scene().folder / "box.seen") == whole);  // nothing new was shown
  const std::vector<Row> rows = rows_of(scene().folder / "remembered.csv");
  REQUIRE(rows.size() == 5);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CAPTURE(i);
    CHECK(rows[i].status == "held");
    const PoseError error = pose_error(scene().poses[i], rows[i].T_camera_object);
    CHECK(error.millimetres < 10);
    CHECK(error.degrees < 5);
  }
  // A model that is completed is remembered as it was given.
  CHECK(track("plain.obj", "both.seen", {"--init", "first.txt", "--complete-model", "whole.obj"}).exit_code == kOk);
  CHECK(track("plain.obj", "both.seen").err.find("found in frame 0") != std::string::npos);

  // Where it is not, nothing is found by it.
  CHECK(scene().track("empty", "plain.obj", {"--remember", "box.seen"}).exit_code == kLost);

  scene().folder.write("half.seen", whole.substr(0, whole.size() / 2));
  check_error(track("plain.obj", "half.seen"), kInput, {"half.seen", "damaged"});
  CHECK(read_file(scene().folder / "half.seen").size() == whole.size() / 2);
  check_error(track("box.obj", "box.seen"), kInput, {"box.seen", "another model"});
  check_error(track("plain.obj", "camera.yml"), kUsage, {"camera.yml"});
  check_error(track("plain.obj", "nowhere/box.seen", {"--init", "first.txt"}), kOutput, {"nowhere/box.seen"});
}

TEST_CASE("The first pose of a file of poses is taken, which is said") {
  std::ostringstream row;
  const Eigen::IOFormat in_one_line(Eigen::FullPrecision, Eigen::DontAlignCols, " ", " ");
  row << scene().poses[0].matrix().topRows<3>().format(in_one_line) << "\n";
  const std::string line = row.str();
  scene().folder.write("many.txt", line + line + line);
  const ProgramRun run = scene().track("frames", "box.obj", {"--init", "many.txt", "--stop", "1", "--quiet"});
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("'many.txt' holds 3 poses") != std::string::npos);
  CHECK(scene().track("frames", "box.obj", {"--init", "first.txt", "--stop", "1", "--quiet"}).err.empty());
}

TEST_CASE("A run that has learned nothing says that it writes nothing") {
  const ProgramRun run = scene().track("empty", "plain.obj", {"--init", "first.txt", "--remember", "nothing.seen"});
  CHECK(run.exit_code == kLost);
  CHECK(run.err.find("'nothing.seen' is not written") != std::string::npos);
  CHECK_FALSE(fs::exists(scene().folder / "nothing.seen"));
}

TEST_CASE("What needs a first pose says so") {
  check_error(scene().track("frames", "box.obj", {"--complete-model", "out.obj"}), kUsage,
              {"--complete-model", "--init"});
}

TEST_CASE("A guide starts a model without texture, once it was seen in three frames") {
  Pose guide = scene().poses[0];
  guide.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d(0.2, 0.5, 0.6).normalized()) * guide.linear();
  guide.translation() += Eigen::Vector3d(0.03, -0.02, 0.06);
  io::save_pose(scene().folder / "guide.txt", guide);
  const ProgramRun run = scene().track("bare", "plain.obj", {"--guide", "guide.txt", "--poses", "guided.csv"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("near the guide") != std::string::npos);
  CHECK(run.err.find("found in frame 2") != std::string::npos);
  const std::vector<Row> rows = rows_of(scene().folder / "guided.csv");
  REQUIRE(rows.size() == 5);
  CHECK(rows[1].status == "lost");
  for (std::size_t i = 2; i < 5; ++i) {
    CHECK(rows[i].status == "held");
    const PoseError error = pose_error(scene().poses[i], rows[i].T_camera_object);
    CHECK(error.millimetres < 10);
    CHECK(error.degrees < 5);
  }
}

TEST_CASE("A guide waits, and what it waits for in vain is lost") {
  io::save_pose(scene().folder / "there.txt", scene().poses[0]);
  const ProgramRun run = scene().track("empty", "plain.obj", {"--guide", "there.txt", "--poses", "waiting.csv"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kLost);
  CHECK(run.err.find("6 frames") != std::string::npos);
  CHECK(run.err.find("as the guide has it") != std::string::npos);
  // Until then the pose of a row is the guide's.
  for (const Row& row : rows_of(scene().folder / "waiting.csv")) check_near(scene().poses[0], row.T_camera_object);
}

TEST_CASE("A model in a wrong unit is said before a guide is looked for in vain") {
  io::save_pose(scene().folder / "there.txt", scene().poses[0]);
  const auto said = [](const std::string& scale) {
    return scene().track("empty", "plain.obj", {"--guide", "there.txt", "--stop", "1", "--model-scale", scale}).err;
  };
  CHECK(said("1").find("warning") == std::string::npos);
  CHECK(said("8").find("times the picture") != std::string::npos);
  CHECK(said("8").find("--model-scale") != std::string::npos);
}

TEST_CASE("Guides that cannot be are refused") {
  io::save_pose(scene().folder / "behind.txt", Pose(Eigen::Translation3d(0, 0, -1)));
  check_error(scene().track("frames", "plain.obj", {"--guide", "behind.txt"}), kInput, {"guide", "behind the camera"});
  check_error(scene().track("frames", "plain.obj", {"--guide", "none.txt"}), kInput, {"none.txt", "does not exist"});
  check_error(scene().track("frames", "plain.obj", {"--guide", "first.txt", "--init", "first.txt"}), kUsage,
              {"--guide", "--init"});
}

TEST_CASE("init finds the pose near a guide, and draws both beside the model") {
  Pose guide = scene().poses[0];
  guide.linear() = Eigen::AngleAxisd(-0.15, Eigen::Vector3d(0.5, 0.2, 0.3).normalized()) * guide.linear();
  guide.translation() += Eigen::Vector3d(-0.02, 0.03, -0.04);
  io::save_pose(scene().folder / "near.txt", guide);
  const auto init = [](const std::string& image, const std::string& picture, Arguments more) {
    Arguments arguments{"init",    "--guide",  "near.txt",   "--image",   image,  "--model",
                        "box.obj", "--camera", "camera.yml", "--picture", picture};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_holdfast(arguments, scene().folder);
  };
  const ProgramRun run = init("frames/0.png", "near.png", {"--pose", "found.txt"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  check_near(scene().poses[0], io::load_pose(scene().folder / "found.txt"));
  const cv::Mat picture = cv::imread((scene().folder / "near.png").string());
  const auto count = [&](const cv::Scalar& color, int off) {
    cv::Mat same;
    cv::inRange(picture, color - cv::Scalar::all(off), color + cv::Scalar::all(off), same);
    return cv::countNonZero(same);
  };
  CHECK(count({120, 255, 90}, 40) > 100);
  CHECK(count({0, 140, 255}, 40) > 100);
  CHECK(picture.cols > 2 * picture.rows);                           // frame and model
  CHECK(count({34, 30, 28}, 0) > picture.rows * picture.rows / 4);  // the model's sheet

  check_error(init("empty/5.png", "away.png", {}), kInput, {"not seen near the guide", "empty/5.png", "picture"});
  CHECK(fs::exists(scene().folder / "away.png"));
  check_error(init("frames/0.png", "near.png", {"--json", "x.json"}), kUsage, {"--json", "--guide"});
}

TEST_CASE("Without a camera the focal length is estimated, said and kept") {
  const auto track = [](const std::string& input, Arguments more) {
    Arguments arguments{"track", input, "--model", "box.obj", "--stop", "5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_holdfast(arguments, scene().folder);
  };
  const ProgramRun run = track("frames", {"--camera-out", "estimated.yml", "--poses", "unknown.csv"});
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("the focal length is estimated") != std::string::npos);
  CHECK(run.err.find("lens distortion is not known") != std::string::npos);
  const Camera camera = io::load_camera(scene().folder / "estimated.yml");
  double focal = 0, sigma = 0;
  REQUIRE(std::sscanf(run.err.c_str() + run.err.find("estimated: "), "estimated: %lf +- %lf", &focal, &sigma) == 2);
  CHECK(camera.fx == doctest::Approx(focal).epsilon(1e-3));
  CHECK(std::abs(focal - 600) < 2 * sigma);
  CHECK(sigma < 0.15 * 600);  // one view tells little
  for (const Row& row : rows_of(scene().folder / "unknown.csv")) CHECK(row.status == "held");

  check_error(track("empty", {"--quiet"}), kInput, {"--camera", "focal length", "less than three of 5 frames"});
  check_error(track("frames", {"--init", "first.txt"}), kUsage, {"--init", "--camera"});
  check_error(scene().track("frames", "box.obj", {"--camera-out", "x.yml"}), kUsage, {"--camera-out", "--camera"});
}
