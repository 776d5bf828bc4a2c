#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/files.hpp"
#include "track/contact_sheet.hpp"
#include "track/output_file.hpp"
#include "track/overlay_video.hpp"
#include "track/pose_writers.hpp"
#include "track/progress.hpp"
#include "track/run_summary.hpp"

namespace fs = std::filesystem;
using holdfast::ErrorCode;
using holdfast::Pose;
using holdfast::Status;
using namespace holdfast::app;
using holdfast::test::error_of;
using holdfast::test::read_file;
using holdfast::test::TemporaryFolder;

namespace {

TrackedFrame make_frame(int index, Status status, double angle) {
  TrackedFrame tracked;
  tracked.frame.index = index;
  tracked.frame.time_s = index / 25.0;
  tracked.ordinal = index;
  holdfast::FrameResult& result = tracked.result;
  result.status = status;
  result.message = status == Status::lost ? "covered, \"too\" much" : "";
  result.T_camera_object = Pose(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -3).normalized()));
  result.T_camera_object.translation() = Eigen::Vector3d(0.1 + index * 1e-7, -0.25, 1.0 / 3.0);
  result.texture = {.asked = true,
                    .holds = true,
                    .visible_pixels = 5000 + index,
                    .usable_pixels = 4000 + index,
                    .gradient_pixels = 3000 + index,
                    .passed_pixels = 2000 + index,
                    .used_pixels = 1000 + index,
                    .residual = 0.01 * (index + 1),
                    .correlation = 0.9};
  result.contour = {.asked = true, .lines = 100, .telling_lines = 90, .near_lines = 80, .agreement = 0.7};
  result.edges = {.asked = true, .lines = 90, .near_lines = 60, .score = 0.6, .residual = 0.4};
  result.iterations = 7;
  result.ms = {0.1, 0.2, 0.3, 0.4, 0.5, 0.05, 2.0 + index};
  result.information(2, 3) = 42.5;
  return tracked;
}

/// Fields of a line of CSV without quotes.
std::vector<std::string> fields_of(const std::string& line, char separator = ',') {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, separator);) {
    fields.push_back(field);
  }
  return fields;
}

std::vector<std::string> lines_of(const fs::path& path) { return fields_of(read_file(path), '\n'); }

Pose pose_from(const std::vector<std::string>& fields, std::size_t first) {
  const auto number = [&](std::size_t i) { return std::stod(fields.at(first + i)); };
  Pose pose(Eigen::Quaterniond(number(6), number(3), number(4), number(5)));
  pose.translation() = Eigen::Vector3d(number(0), number(1), number(2));
  return pose;
}

constexpr double kAngles[] = {0.0, 0.3, 3.1, -2.9, 3.14159265358979};  // about the half turn qw changes its sign

}  // namespace

TEST_CASE("a CSV row holds the frame's pose and figures, and is there at once") {
  const TemporaryFolder folder;
  CsvWriter writer(folder / "poses.csv");
  const std::vector<std::string> header = fields_of(lines_of(folder / "poses.csv").at(0));
  REQUIRE(header == std::vector<std::string>{"frame",
                                             "time_s",
                                             "status",
                                             "tx",
                                             "ty",
                                             "tz",
                                             "qx",
                                             "qy",
                                             "qz",
                                             "qw",
                                             "visible",
                                             "usable",
                                             "gradient",
                                             "passed",
                                             "used",
                                             "residual",
                                             "correlation",
                                             "iterations",
                                             "ms",
                                             "reason",
                                             "texture_holds",
                                             "contour_holds",
                                             "snapshot_holds"});
  int index = 0;
  for (const double angle : kAngles) {
    const TrackedFrame tracked = make_frame(index, Status::held, angle);
    writer.write(tracked);
    const std::vector<std::string> lines = lines_of(folder / "poses.csv");
    REQUIRE(lines.size() == static_cast<std::size_t>(index) + 2);
    const std::vector<std::string> fields = fields_of(lines.back());
    REQUIRE(fields.size() >= 19);
    CHECK(fields[0] == std::to_string(index));
    CHECK(std::stod(fields[1]) == doctest::Approx(index / 25.0));
    CHECK(fields[2] == "held");
    CHECK(pose_from(fields, 3).isApprox(tracked.result.T_camera_object, 1e-8));
    CHECK(std::stod(fields[9]) >= 0);
    CHECK(fields[10] == std::to_string(5000 + index));
    CHECK(fields[14] == std::to_string(1000 + index));
    CHECK(std::stod(fields[15]) == doctest::Approx(0.01 * (index + 1)));
    CHECK(std::stod(fields[18]) == doctest::Approx(2.0 + index));
    ++index;
  }
  writer.write(make_frame(9, Status::lost, 0));
  CHECK(lines_of(folder / "poses.csv").back().find(",lost,") != std::string::npos);
  CHECK(lines_of(folder / "poses.csv").back().ends_with(",\"covered, \"\"too\"\" much\",1,0,0"));
  TrackedFrame by_contour = make_frame(10, Status::held, 0);
  by_contour.result.texture.holds = false;
  by_contour.result.contour.holds = true;
  writer.write(by_contour);
  CHECK(lines_of(folder / "poses.csv").back().ends_with(",,0,1,0"));
}

TEST_CASE("a TUM file holds the frames that are held") {
  const TemporaryFolder folder;
  TumWriter writer(folder / "poses.txt");
  for (int i = 0; i < 5; ++i) {
    writer.write(make_frame(i, i == 2 ? Status::lost : Status::held, kAngles[i]));
  }
  const std::vector<std::string> lines = lines_of(folder / "poses.txt");
  REQUIRE(lines.size() == 4);
  int row = 0;
  for (const int i : {0, 1, 3, 4}) {
    const std::vector<std::string> fields = fields_of(lines[row++], ' ');
    REQUIRE(fields.size() == 8);
    CHECK(std::stod(fields[0]) == doctest::Approx(i / 25.0));
    CHECK(pose_from(fields, 1).isApprox(make_frame(i, Status::held, kAngles[i]).result.T_camera_object, 1e-8));
  }
}

TEST_CASE("a JSON file is valid after every frame") {
  const TemporaryFolder folder;
  const fs::path path = folder / "run.json";
  SummaryBuilder figures;
  JsonWriter writer(path, R"({"input": "a \"b\""})");
  for (int i = 0; i < 5; ++i) {
    const nlohmann::json so_far = nlohmann::json::parse(read_file(path));
    CHECK(so_far["run"]["input"] == "a \"b\"");
    CHECK(so_far["frames"].size() == static_cast<std::size_t>(i));
    TrackedFrame tracked = make_frame(i, i == 3 ? Status::lost : Status::held, kAngles[i]);
    tracked.result.texture.holds = i != 1;
    tracked.result.contour.holds = true;
    writer.write(tracked);
    figures.add(tracked);
  }
  PipelineReport report;
  report.frames = 5;
  report.wall_s = 2.4;
  report.first.wall_s = 0.8;
  writer.finish(figures.summary(report));
  const nlohmann::json whole = nlohmann::json::parse(read_file(path));
  REQUIRE(whole["frames"].size() == 5);
  const nlohmann::json& frame = whole["frames"][3];
  CHECK(frame["frame"] == 3);
  CHECK(frame["status"] == "lost");
  CHECK(frame["translation"][2].get<double>() == doctest::Approx(1.0 / 3.0));
  CHECK(frame["information"][2][3].get<double>() == 42.5);
  CHECK(frame["pixels"]["used"] == 1003);
  CHECK(frame["ms"]["total"].get<double>() == 5.0);
  CHECK(frame["texture_holds"] == true);
  CHECK(whole["frames"][1]["texture_holds"] == false);
  CHECK(frame["contour_holds"] == true);
  CHECK(frame["contour"]["lines"] == 100);
  CHECK(frame["contour"]["near"] == 80);
  CHECK(frame["contour"]["agreement"] == 0.7);
  CHECK(frame["edges"] == nlohmann::json::parse(R"({"lines": 90, "near": 60, "score": 0.6, "residual": 0.4})"));
  CHECK(frame["ms"]["contour"] == 0.05);
  CHECK(whole["summary"]["held"] == 4);
  CHECK(whole["summary"]["held_by_contour"] == 1);
  CHECK(whole["summary"]["texture_left"].is_null());
  CHECK(whole["summary"]["by_texture"] == true);
  CHECK(whole["summary"]["lost_ranges"] == nlohmann::json::parse("[[3, 3]]"));
  CHECK(whole["summary"]["complete"] == true);
  CHECK(whole["summary"]["frames_per_second"].get<double>() == 2.5);
}

TEST_CASE("JSON goes through a pipe too") {
  const TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  std::string received;
  std::thread reader([&] { received = read_file(pipe); });
  {
    JsonWriter writer(pipe, "{}");
    writer.write(make_frame(0, Status::held, 0));
    writer.write(make_frame(1, Status::held, 0));
    writer.finish({});
  }
  reader.join();
  CHECK(nlohmann::json::parse(received)["frames"].size() == 2);
}

TEST_CASE("files that cannot be written are named with the reason") {
  const TemporaryFolder folder;
  CHECK(error_of([&] {
          CsvWriter(folder / "none" / "a.csv");
        }).says(ErrorCode::output, {"a.csv", "the folder", "does not exist"}));
  CHECK(error_of([&] { TumWriter(folder.path()); }).says(ErrorCode::output, {folder.path().c_str(), "directory"}));
  CHECK(error_of([&] { require_writable(folder / "none" / "a.csv"); }).says(ErrorCode::output, {"does not exist"}));
  CHECK(error_of([&] { OverlayVideo(folder / "a.gif", {64, 48}, 25); }).says(ErrorCode::output, {"a.gif", ".mp4"}));
  CHECK(error_of([&] { OverlayVideo(folder / "none" / "a.mp4", {64, 48}, 25); }).says(ErrorCode::output, {"a.mp4"}));
  CHECK(error_of([&] { ContactSheet(folder / "a.xyz", 5, {}); }).says(ErrorCode::output, {"a.xyz", ".png"}));
  CHECK(error_of([&] { ContactSheet(folder / "a.png", 0, {}); }).says(ErrorCode::invalid_argument, {"0"}));
}

TEST_CASE("a full disk is noticed at the first byte that does not fit") {
  REQUIRE(fs::exists("/dev/full"));
  CHECK(error_of([] { CsvWriter("/dev/full"); }).says(ErrorCode::output, {"/dev/full", "No space left"}));
  TumWriter tum("/dev/full");
  CHECK(error_of([&] { tum.write(make_frame(0, Status::held, 0)); }).says(ErrorCode::output, {"No space left"}));
}

namespace {

/// While this lives, files of this process may not grow beyond `bytes`, as on a full disk.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

}  // namespace

TEST_CASE("on a full disk, files end with the last frame that had room as a whole") {
  const TemporaryFolder folder;
  const fs::path json_path = folder / "run.json", csv_path = folder / "poses.csv";
  JsonWriter json(json_path, "{}");
  CsvWriter csv(csv_path);
  std::size_t in_json = 0, in_csv = 0;
  {
    const SmallDisk disk(3000);
    const auto frames_until_full = [](auto& writer) {
      std::size_t frames = 0;
      const auto write_one = [&] { writer.write(make_frame(static_cast<int>(frames), Status::held, 0)); };
      while (frames < 1000 && error_of(write_one).message.empty()) ++frames;
      CHECK(error_of(write_one).says(ErrorCode::output, {"File too large"}));
      return frames;
    };
    in_json = frames_until_full(json);
    in_csv = frames_until_full(csv);
    CHECK(error_of([&] {
            RunSummary summary;
            summary.lost_ranges.resize(200);
            json.finish(summary);
          }).says(ErrorCode::output, {"run.json"}));
  }
  CHECK(in_json > 0);
  CHECK(in_csv > 0);
  CHECK(nlohmann::json::parse(read_file(json_path))["frames"].size() == in_json);
  const std::string rows = read_file(csv_path);
  CHECK(rows.ends_with('\n'));
  CHECK(static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')) == in_csv + 1);
  CHECK(rows.size() < 3000);
  csv.write(make_frame(999, Status::held, 0));  // there is room again
  CHECK(read_file(csv_path).starts_with(rows));
}

TEST_CASE("asking whether a file can be written leaves it as it is") {
  const TemporaryFolder folder;
  const fs::path kept = folder.write("kept.csv", "earlier results");
  require_writable(kept);
  require_writable(folder / "new.csv");
  CHECK(read_file(kept) == "earlier results");
  CHECK_FALSE(fs::exists(folder / "new.csv"));
}

TEST_CASE("an overlay video can be read back") {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.mkv", "a.avi", "a.mov"}) {
    CAPTURE(name);
    OverlayVideo video(folder / name, {128, 96}, 20);
    for (int i = 0; i < 12; ++i) {
      video.write(cv::Mat(96, 128, CV_8UC3, cv::Scalar::all(20 * i)));
    }
    video.finish();
    cv::VideoCapture capture((folder / name).string(), cv::CAP_FFMPEG);
    CHECK(capture.get(cv::CAP_PROP_FPS) == doctest::Approx(20));
    cv::Mat picture;
    int frames = 0;
    for (; capture.read(picture); ++frames) {
      CHECK(std::abs(cv::mean(picture)[1] - 20 * frames) < 6);
    }
    CHECK(frames == 12);
  }
}

TEST_CASE("a contact sheet shows frames spread over the run") {
  const TemporaryFolder folder;
  const auto shown_of = [&](int frames, std::optional<std::int64_t> expected, std::int64_t run) {
    ContactSheet sheet(folder / "sheet.png", frames, expected);
    std::vector<std::int64_t> wanted;
    for (std::int64_t i = 0; i < run; ++i) {
      if (sheet.wants(i)) {
        wanted.push_back(i);
      }
    }
    return wanted;
  };
  // Every frame first, then ever fewer, and not more than it takes where the length is announced.
  CHECK(shown_of(5, 3, 3) == std::vector<std::int64_t>{0, 1, 2});
  CHECK(shown_of(5, {}, 20).size() == 20);
  CHECK(shown_of(5, {}, 100000).size() < 250);
  CHECK(shown_of(5, 100000, 100000).size() < 25);
  // Videos announce a frame too many, and runs are interrupted.
  for (const std::int64_t announced : {454, 455, 456, 600}) {
    CAPTURE(announced);
    const std::vector<std::int64_t> shown = shown_of(20, announced, 455);
    CHECK(shown.size() >= 40);
    CHECK(shown.size() < 80);
    CHECK(shown.back() >= 440);
  }

  for (const std::optional<std::int64_t> expected :
       {std::optional<std::int64_t>(300), std::optional<std::int64_t>(310), std::optional<std::int64_t>()}) {
    ContactSheet sheet(folder / "sheet.png", 6, expected);
    for (int i = 0; i < 300; ++i) {
      if (sheet.wants(i)) {
        sheet.add(make_frame(i, Status::held, 0), cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, i * 255 / 300, 255)));
      }
    }
    sheet.finish();
    const cv::Mat picture = cv::imread((folder / "sheet.png").string());
    REQUIRE(picture.size() == cv::Size(4 * 324 + 4, 2 * 244 + 4));
    std::vector<int> greens;
    for (int i = 0; i < 6; ++i) {
      greens.push_back(picture.at<cv::Vec3b>(i / 4 * 244 + 200, i % 4 * 324 + 160)[1]);
    }
    CHECK(greens.front() <= 5);
    CHECK(greens.back() >= 230);
    for (int i = 1; i < 6; ++i) {
      CHECK(std::abs(greens[i] - greens[i - 1] - 50) < 10);
    }
  }
}

TEST_CASE("a summary counts, and takes medians of what is held") {
  SummaryBuilder figures;
  for (const int i : {0, 1, 2, 3, 4, 5, 6}) {
    figures.add(make_frame(i, i == 2 || i == 3 || i == 6 ? Status::lost : Status::held, 0));
  }
  PipelineReport report;
  report.frames = 7;
  report.wall_s = 0.5;
  report.read_s = 0.07;
  report.track_s = 0.935;
  report.first = {0.2, 0.01, 0.9, 0};  // kernels were compiled
  const RunSummary summary = figures.summary(report);
  CHECK(summary.held == 4);
  CHECK(summary.lost == 3);
  REQUIRE(summary.lost_ranges.size() == 2);
  CHECK(summary.lost_ranges[0].first == 2);
  CHECK(summary.lost_ranges[0].last == 3);
  CHECK(summary.lost_ranges[1].first == 6);
  CHECK(summary.median_ms == doctest::Approx(4.5));                           // of 2 3 6 7
  CHECK(summary.median_lost_ms == doctest::Approx(5.0));                      // of 4 5 8
  CHECK(summary.median_residual == doctest::Approx((0.02 + 0.05) / 2));       // of .01 .02 .05 .06
  CHECK(summary.median_used_pixels == doctest::Approx((1001 + 1004) / 2.0));  // of frames 0 1 4 5
  CHECK(summary.frames_per_second == doctest::Approx(20));                    // 6 in 0.3 s
  CHECK(summary.track_ms == doctest::Approx(35.0 / 6));
  CHECK(summary.read_ms == doctest::Approx(10));
  CHECK(summary.mean_ms.solve == doctest::Approx(0.5));
  const std::string text = summary_text(summary);
  CHECK(text.find("7 frames: 4 held, 3 lost") != std::string::npos);
  CHECK(text.find("frames 2 to 3, 6; in frame 2: covered") != std::string::npos);
  CHECK(text.find("20 frames a second after the first; a frame takes 10.00 ms to read") != std::string::npos);
  CHECK(text.find("reading is the slowest") != std::string::npos);
}

TEST_CASE("a median of ever more values takes no more memory, whatever order they come in") {
  constexpr int kValues = 300000;
  RunningMedian rising, by_turns;
  for (int i = 0; i < kValues; ++i) {
    rising.add(i);
    by_turns.add(i % 2 == 0 ? i : kValues + i);  // what every second frame takes
  }
  CHECK(rising.kept() == RunningMedian::kMost);
  // Of n values drawn at random, the median's rank has a standard deviation of 0.5 / sqrt(n).
  const double bound = 4 * 0.5 / std::sqrt(static_cast<double>(RunningMedian::kMost));
  CHECK(std::abs(rising.value() / kValues - 0.5) < bound);
  CHECK(std::abs(by_turns.value() / (2 * kValues) - 0.5) < bound);
}

TEST_CASE("a summary's residuals are in one unit: the texture's, or the contour's where most are held without") {
  const auto summary_of = [](int by_contour) {
    SummaryBuilder builder;
    for (int i = 0; i < 5; ++i) {
      TrackedFrame tracked = make_frame(i, Status::held, 0);
      tracked.result.contour.residual = 0.5;
      tracked.result.contour.holds = true;
      tracked.result.texture.holds = i >= by_contour;
      builder.add(tracked);
    }
    return builder.summary({});
  };
  const RunSummary some = summary_of(2);
  CHECK(some.held_by_contour == 2);
  CHECK(some.median_residual == doctest::Approx(0.04));
  CHECK(summary_text(some).find("contour  2 of the frames held") != std::string::npos);
  CHECK(summary_text(some).find("residual 0.0400\n") != std::string::npos);
  const RunSummary most = summary_of(3);
  CHECK(most.median_residual == 0.5);
  CHECK(summary_text(most).find("lines across the contour used, residual 0.5000 pixels") != std::string::npos);
  CHECK(summary_text(summary_of(0)).find("  contour") == std::string::npos);
}

TEST_CASE("a summary says from which frame on the texture is left out") {
  const auto text_of = [](int left, bool textured) {
    SummaryBuilder builder;
    for (int i = 0; i < 5; ++i) {
      TrackedFrame tracked = make_frame(i, Status::held, 0);
      tracked.result.texture.asked = textured && i < left;
      tracked.result.snapshot.asked = !tracked.result.texture.asked;
      builder.add(tracked);
    }
    return summary_text(builder.summary({}));
  };
  CHECK(text_of(3, true).find("left out from frame 3 on") != std::string::npos);
  CHECK(text_of(5, true).find("  texture") == std::string::npos);
  CHECK(text_of(0, false).find("  texture") == std::string::npos);
}

TEST_CASE("progress tells what is known") {
  CHECK(progress_text(120, 455, 0.5) == "120 of 455 frames, 26 %, 240 frames a second, 2 s left");
  CHECK(progress_text(10, 100000, 5) == "10 of 100000 frames, 0 %, 2.0 frames a second, 13:53 h left");
  CHECK(progress_text(10, 610, 5) == "10 of 610 frames, 1 %, 2.0 frames a second, 5:00 min left");
  CHECK(progress_text(30, std::nullopt, 1) == "30 frames, 30 frames a second");
  CHECK(progress_text(0, 10, 0) == "0 of 10 frames, 0 %");
}

TEST_CASE("progress is silent where there is no terminal") {
  std::FILE* file = std::tmpfile();
  {
    Progress progress(file, 1000);
    for (int i = 0; i < 5; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
      progress.update(i, true);
    }
  }
  CHECK(std::ftell(file) == 0);
  std::fclose(file);
}
