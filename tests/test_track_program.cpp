// `track` as a command: what it writes, where it refuses to start, and what is left when it ends early.
#include <doctest/doctest.h>
#include <sys/types.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>
#include <vector>

#include "commands.hpp"
#include "config_file.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "support/files.hpp"
#include "support/small_sequence.hpp"

namespace fs = std::filesystem;
using holdfast::ErrorCode;
using holdfast::Pose;
using namespace holdfast::app;
using holdfast::test::error_of;
using holdfast::test::read_file;
using holdfast::test::TemporaryFolder;

namespace {

/// A tiny sequence on disk, and the command that follows it.
class SequenceOnDisk {
 public:
  explicit SequenceOnDisk(int frames) : poses(holdfast::test::write_small_sequence(folder, frames)) {}

  /// `holdfast track` with the sequence's own inputs and `more`; returns the exit code, throws what the program
  /// reports.
  int track(const std::vector<std::string>& more, const std::string& input = "") const {
    CLI::App app;
    enable_config_file(app);
    int exit_code = kOk;
    holdfast::add_track_command(app, exit_code);
    std::vector<std::string> arguments = {"track",    input.empty() ? (folder / "frames").string() : input,
                                          "--model",  (folder / "box.obj").string(),
                                          "--camera", (folder / "camera.yml").string(),
                                          "--init",   (folder / "first.txt").string(),
                                          "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
    return exit_code;
  }

  std::string file(const std::string& name) const { return (folder / name).string(); }

  TemporaryFolder folder;
  std::vector<Pose> poses;
};

struct Row {
  int frame = 0;
  std::string status;
  Pose T_camera_object;
};

std::vector<Row> rows_of(const fs::path& csv) {
  std::vector<Row> rows;
  std::istringstream lines(read_file(csv));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) {
      fields.push_back(field);
    }
    const auto number = [&](std::size_t i) { return std::stod(fields.at(i)); };
    Row row;
    row.frame = std::stoi(fields.at(0));
    row.status = fields.at(2);
    row.T_camera_object = Pose(Eigen::Quaterniond(number(9), number(6), number(7), number(8)));
    row.T_camera_object.translation() = Eigen::Vector3d(number(3), number(4), number(5));
    rows.push_back(row);
  }
  return rows;
}

int frames_in(const fs::path& video) {
  cv::VideoCapture capture(video.string(), cv::CAP_FFMPEG);
  cv::Mat picture;
  int frames = 0;
  while (capture.read(picture)) {
    ++frames;
  }
  return frames;
}

/// FFmpeg speaks on stderr of files spoiled on purpose.
const int ffmpeg_is_silent = setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);

}  // namespace

TEST_CASE("track follows a sequence and writes all that is asked for") {
  const SequenceOnDisk sequence(12);
  const int exit_code =
      sequence.track({"--poses", sequence.file("poses.csv"), "--tum", sequence.file("poses.txt"), "--json",
                      sequence.file("run.json"), "--overlay", sequence.file("overlay.mp4"), "--contact-sheet",
                      sequence.file("sheet.png"), "--contact-frames", "4", "--require-held"});
  CHECK(exit_code == kOk);
  const std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 12);
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    CHECK(rows[i].frame == i);
    CHECK(rows[i].status == "held");
    const Pose error = rows[i].T_camera_object.inverse() * sequence.poses[i];
    CHECK(error.translation().norm() < 0.01);
    CHECK(holdfast::rotation_angle(error.linear()) < 2 * M_PI / 180);
  }
  const nlohmann::json run = nlohmann::json::parse(read_file(sequence.folder / "run.json"));
  CHECK(run["frames"].size() == 12);
  CHECK(run["summary"]["complete"] == true);
  CHECK(run["run"]["camera"]["fx"] == 325);
  CHECK(frames_in(sequence.folder / "overlay.mp4") == 12);
  CHECK_FALSE(cv::imread(sequence.file("sheet.png")).empty());
  CHECK(holdfast::io::load_poses(sequence.folder / "poses.txt").size() == 12);
}

TEST_CASE("the same poses come out whatever else is written, and from run to run") {
  const SequenceOnDisk sequence(6);
  REQUIRE(sequence.track({"--poses", sequence.file("a.csv")}) == kOk);
  REQUIRE(sequence.track({"--poses", sequence.file("b.csv"), "--overlay", sequence.file("o.mp4")}) == kOk);
  const std::vector<Row> a = rows_of(sequence.folder / "a.csv");
  const std::vector<Row> b = rows_of(sequence.folder / "b.csv");
  REQUIRE(a.size() == 6);
  REQUIRE(b.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(a[i].T_camera_object.matrix() == b[i].T_camera_object.matrix());
  }
}

TEST_CASE("an object that is not there is lost, and --require-held tells it by the exit code") {
  const SequenceOnDisk sequence(4);
  for (int i = 1; i < 4; ++i) {
    cv::Mat noise(240, 320, CV_8UC3);
    cv::randu(noise, 0, 255);
    cv::imwrite(sequence.file("frames/" + std::to_string(i) + ".png"), noise);
  }
  CHECK(sequence.track({"--poses", sequence.file("poses.csv")}) == kOk);
  const std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].status == "held");
  CHECK(rows[3].status == "lost");
  CHECK(sequence.track({"--require-held"}) == kLost);
}

TEST_CASE("options come from a configuration file, the command line wins") {
  const SequenceOnDisk sequence(5);
  sequence.folder.write("run.toml", "stop = 4\nstride = 2\nposes = \"" + sequence.file("poses.csv") + "\"\n");
  REQUIRE(sequence.track({"--config", sequence.file("run.toml")}) == kOk);
  std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 2);
  CHECK(rows[1].frame == 2);
  REQUIRE(sequence.track({"--config", sequence.file("run.toml"), "--stride", "1"}) == kOk);
  CHECK(rows_of(sequence.folder / "poses.csv").size() == 4);
}

TEST_CASE("an interrupted run leaves complete files") {
  const SequenceOnDisk sequence(3);
  for (int i = 3; i < 2000; ++i) {  // goes on without motion for longer than anybody waits
    fs::create_hard_link(sequence.file("frames/2.png"), sequence.file("frames/" + std::to_string(i) + ".png"));
  }
  std::atomic<bool> sent = false;
  std::thread impatient([&] {
    for (int waited_ms = 0; waited_ms < 60000 && !sent; waited_ms += 5) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (fs::exists(sequence.folder / "poses.csv") && rows_of(sequence.folder / "poses.csv").size() >= 5) {
        sent = true;
        kill(getpid(), SIGINT);
      }
    }
  });
  const int exit_code =
      sequence.track({"--poses", sequence.file("poses.csv"), "--tum", sequence.file("poses.txt"), "--json",
                      sequence.file("run.json"), "--overlay", sequence.file("overlay.mp4")});
  impatient.join();
  REQUIRE(sent);
  CHECK(exit_code == kInterrupted);
  const std::size_t rows = rows_of(sequence.folder / "poses.csv").size();
  CHECK(rows >= 5);
  CHECK(rows < 2000);
  CHECK(read_file(sequence.folder / "poses.csv").ends_with("\n"));
  const nlohmann::json run = nlohmann::json::parse(read_file(sequence.folder / "run.json"));
  CHECK(run["frames"].size() == rows);
  CHECK(run["summary"]["complete"] == false);
  CHECK(static_cast<std::size_t>(frames_in(sequence.folder / "overlay.mp4")) == rows);
}

TEST_CASE("what ends a run early leaves the poses so far in the files") {
  const SequenceOnDisk sequence(6);
  const std::vector<std::string> outputs = {"--poses", sequence.file("poses.csv")};
  SUBCASE("a frame of another size") {
    cv::imwrite(sequence.file("frames/4.png"), cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(9)));
    CHECK(error_of([&] { sequence.track(outputs); }).says(ErrorCode::image, {"frame 4", "100x100", "320x240"}));
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 4);
  }
  SUBCASE("an unreadable image") {
    sequence.folder.write("frames/3.png", "text");
    CHECK(error_of([&] { sequence.track(outputs); }).says(ErrorCode::file, {"frame 3", "3.png"}));
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 3);
  }
  SUBCASE("a video that ends mid-frame") {
    {
      cv::VideoWriter video(sequence.file("v.avi"), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                            {320, 240});
      for (int i = 0; i < 6; ++i) {
        video.write(cv::imread(sequence.file("frames/" + std::to_string(i) + ".png")));
      }
    }
    const std::string whole = read_file(sequence.folder / "v.avi");
    sequence.folder.write("cut.avi", whole.substr(0, whole.size() * 6 / 10));
    CHECK(sequence.track(outputs, sequence.file("v.avi")) == kOk);
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 6);
    CHECK(sequence.track(outputs, sequence.file("cut.avi")) == kInput);
    const std::size_t rows = rows_of(sequence.folder / "poses.csv").size();
    CHECK(rows >= 2);
    CHECK(rows < 6);
  }
}

TEST_CASE("runs that cannot succeed are refused before they overwrite anything") {
  const SequenceOnDisk sequence(2);
  const fs::path kept = sequence.folder.write("kept.csv", "earlier results");
  const auto error = [&](std::vector<std::string> more, const std::string& input = "") {
    more.insert(more.end(), {"--poses", kept.string()});
    return error_of([&] { sequence.track(more, input); });
  };
  CHECK(error({"--tum", sequence.file("none/a.txt")}).says(ErrorCode::output, {"none/a.txt", "does not exist"}));
  CHECK(error({"--tum", sequence.file("./kept.csv")}).says(ErrorCode::invalid_argument, {"two results", "kept.csv"}));
  CHECK(error({"--tum", sequence.file("first.txt")}).says(ErrorCode::invalid_argument, {"is an input", "first.txt"}));
  CHECK(error({"--start", "9"}).says(ErrorCode::invalid_argument, {"--start 9"}));
  CHECK(error({"--contact-sheet", sequence.file("s.png"), "--contact-frames", "0"})
            .says(ErrorCode::invalid_argument, {"--contact-frames 0"}));
  CHECK(error({}, sequence.file("none")).says(ErrorCode::file, {"none"}));
  holdfast::io::save_pose(sequence.folder / "first.txt", Pose(Eigen::Translation3d(0, 0, -1)));
  CHECK(error({}).says(ErrorCode::pose, {"behind the camera"}));
  CHECK(read_file(kept) == "earlier results");
}
