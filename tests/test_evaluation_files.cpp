// What `holdfast evaluate` reads and writes: sequence folders, BOP scenes, tables of poses, reports. Every kind of bad
// input gives one line that names the file and what is wrong with it.
#include <doctest/doctest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "config_file.hpp"
#include "evaluation/estimated_poses.hpp"
#include "evaluation/folder_names.hpp"
#include "evaluation/marked_points.hpp"
#include "evaluation/model_choice.hpp"
#include "evaluation/occluder_use.hpp"
#include "evaluation/plots.hpp"
#include "evaluation/pose_comparison.hpp"
#include "evaluation/report.hpp"
#include "evaluation/sequence.hpp"
#include "holdfast/error.hpp"

using namespace holdfast;
using namespace holdfast::evaluation;
namespace fs = std::filesystem;

namespace {

/// A folder of its own, gone at the end of the test.
class Folder {
 public:
  Folder() {
    static int number = 0;
    path_ = fs::temp_directory_path() /
            ("holdfast_evaluation_" + std::to_string(getpid()) + "_" + std::to_string(number++));
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path operator/(const std::string& name) const { return path_ / name; }
  const fs::path& path() const { return path_; }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name) << text;
  }
  void write_image(const std::string& name, int width = 64, int height = 48) const {
    fs::create_directories((path_ / name).parent_path());
    cv::imwrite((path_ / name).string(), cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 20, 30)));
  }

 private:
  fs::path path_;
};

/// The message of the Error that `action` throws; a failure of the test when it throws none or another kind.
template <class Action>
std::string message_of(ErrorCode code, Action action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(error.code() == code);
    const std::string message = error.what();
    CHECK(message.find('\n') == std::string::npos);
    return message;
  }
  FAIL("no error");
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

const std::string kIdentityAt500 = "1 0 0 0 0 1 0 0 0 0 1 0.5\n";
const std::string kTurnedAt600 = "0 -1 0 0.1 1 0 0 0.2 0 0 1 0.6\n";

/// Two frames of 64 x 48.
void write_sequence(const Folder& folder) {
  folder.write("poses_gt.txt", kIdentityAt500 + kTurnedAt600);
  folder.write("K.txt", "60 61 31.5 23.5\n");
  folder.write("visible.txt", "1.000\n0.250\n");
  folder.write_image("frames/000000.png");
  folder.write_image("frames/000001.png");
}

const char* const kBopTruth = R"({
  "10": [{"cam_R_m2c": [0,-1,0, 1,0,0, 0,0,1], "cam_t_m2c": [1, 2, 900], "obj_id": 4},
         {"cam_R_m2c": [1,0,0, 0,1,0, 0,0,1], "cam_t_m2c": [-7, 5, 1000], "obj_id": 9}],
  "2": [{"cam_R_m2c": [1,0,0, 0,1,0, 0,0,1], "cam_t_m2c": [100, -50, 750.5], "obj_id": 9},
        {"cam_R_m2c": [1,0,0, 0,1,0, 0,0,1], "cam_t_m2c": [0, 0, 800], "obj_id": 4}]})";
const char* const kBopCamera = R"({"2": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1], "depth_scale": 1.0},
  "10": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1]}})";

void write_bop(const Folder& folder) {
  folder.write("scene_gt.json", kBopTruth);
  folder.write("scene_camera.json", kBopCamera);
  folder.write("scene_gt_info.json", R"({"10": [{"visib_fract": 0.4}, {"visib_fract": 0.5}],
                                         "2": [{"visib_fract": 0.9}, {"visib_fract": 0.8}]})");
  folder.write_image("rgb/000002.png");
  folder.write_image("rgb/000010.png");
}

/// `holdfast evaluate ...` as the program runs it.
void run_evaluate(std::vector<std::string> arguments) {
  CLI::App app;
  int exit_code = 0;
  app::enable_config_file(app);
  add_evaluate_command(app, exit_code);
  arguments.insert(arguments.begin(), "evaluate");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
}

}  // namespace

TEST_CASE("sequence folder: frames, camera, truth, visible shares") {
  const Folder folder;
  write_sequence(folder);
  const Sequence sequence = load_sequence(folder.path() / "");
  CHECK(sequence.name == folder.path().filename().string());
  REQUIRE(sequence.frames.size() == 2);
  CHECK(sequence.frames[1].filename() == "000001.png");
  CHECK(sequence.camera.width == 64);
  CHECK(sequence.camera.height == 48);
  CHECK(sequence.camera.fy == 61);
  REQUIRE(sequence.truth.size() == 2);
  CHECK(sequence.truth[1].translation().isApprox(Eigen::Vector3d(0.1, 0.2, 0.6)));
  CHECK(sequence.truth[1].linear()(1, 0) == doctest::Approx(1));
  CHECK(sequence.visible == std::vector<double>{1, 0.25});
  CHECK(sequence.model_scale == 1);
}

TEST_CASE("sequence folder: natural order, what systems leave beside pictures, byte order marks") {
  const Folder folder;
  write_sequence(folder);
  fs::rename(folder / "frames/000000.png", folder / "frames/9.png");
  fs::rename(folder / "frames/000001.png", folder / "frames/10.png");
  folder.write("frames/._9.png", "resource fork");
  folder.write("visible.txt",
               "\xef\xbb\xbf"
               "1.000\r\n0.250\r\n");
  const Sequence sequence = load_sequence(folder.path());
  REQUIRE(sequence.frames.size() == 2);
  CHECK(sequence.frames[0].filename() == "9.png");
  CHECK(sequence.visible == std::vector<double>{1, 0.25});
  folder.write("marks.csv",
               "\xef\xbb\xbf"
               "0,0,0,0.5,10,10\r\n");
  CHECK(load_marked_points(folder / "marks.csv").size() == 1);
}

TEST_CASE("sequence folder: bad input") {
  const auto message = [](ErrorCode code, const Folder& folder) {
    return message_of(code, [&] { load_sequence(folder.path()); });
  };
  SUBCASE("no folder") {
    const Folder folder;
    const std::string text = message_of(ErrorCode::file, [&] { load_sequence(folder / "missing"); });
    CHECK(contains(text, "missing"));
    CHECK(contains(text, "no such folder"));
  }
  SUBCASE("empty folder") {
    const Folder folder;
    const std::string text = message(ErrorCode::file, folder);
    CHECK(contains(text, folder.path().string()));
    CHECK(contains(text, "poses_gt.txt"));
    CHECK(contains(text, "scene_gt.json"));
  }
  SUBCASE("no images") {
    const Folder folder;
    write_sequence(folder);
    fs::remove(folder / "frames/000000.png");
    fs::remove(folder / "frames/000001.png");
    CHECK(contains(message(ErrorCode::file, folder), "no image files"));
  }
  SUBCASE("more frames than poses") {
    const Folder folder;
    write_sequence(folder);
    folder.write_image("frames/000002.png");
    const std::string text = message(ErrorCode::file, folder);
    CHECK(contains(text, "3 frames"));
    CHECK(contains(text, "2 true poses"));
  }
  SUBCASE("fewer visible shares than poses") {
    const Folder folder;
    write_sequence(folder);
    folder.write("visible.txt", "1\n");
    CHECK(contains(message(ErrorCode::file, folder), "1 visible shares but 2 true poses"));
  }
  SUBCASE("a visible share that is none") {
    const Folder folder;
    write_sequence(folder);
    folder.write("visible.txt", "1\n1.5\n");
    CHECK(contains(message(ErrorCode::file, folder), "line 2"));
  }
  SUBCASE("fewer occluder masks than poses") {
    const Folder folder;
    write_sequence(folder);
    folder.write_image("masks/000000.png");
    const std::string text = message(ErrorCode::file, folder);
    CHECK(contains(text, "masks"));
    CHECK(contains(text, "1 images but 2 true poses"));
  }
  SUBCASE("a pose that is no rotation") {
    const Folder folder;
    write_sequence(folder);
    folder.write("poses_gt.txt", kIdentityAt500 + "1 0 0 0 0 1 0 0 0 0 2 0.5\n");
    const std::string text = message(ErrorCode::pose, folder);
    CHECK(contains(text, "poses_gt.txt"));
    CHECK(contains(text, "line 2"));
  }
  SUBCASE("a pose that mirrors") {
    const Folder folder;
    write_sequence(folder);
    folder.write("poses_gt.txt", kIdentityAt500 + "1 0 0 0 0 1 0 0 0 0 -1 0.5\n");
    CHECK(contains(message(ErrorCode::pose, folder), "line 2"));
  }
  SUBCASE("no camera") {
    const Folder folder;
    write_sequence(folder);
    fs::remove(folder / "K.txt");
    CHECK(contains(message(ErrorCode::file, folder), "K.txt"));
  }
  SUBCASE("an unreadable first image") {
    const Folder folder;
    write_sequence(folder);
    folder.write("frames/000000.png", "not an image");
    CHECK(contains(message(ErrorCode::file, folder), "000000.png"));
  }
}

TEST_CASE("sequences of the same name are told apart by the folders above, by no more than it takes") {
  using Names = std::vector<std::string>;
  CHECK(distinct_names({"/a/x", "/b/y/"}) == Names{"x", "y"});
  CHECK(distinct_names({"/a/x", "/b/x/", "/b/y"}) == Names{"a_x", "b_x", "y"});
  CHECK(distinct_names({"/a/1/x", "/b/1/x", "/b/2/x"}) == Names{"a_1_x", "b_1_x", "2_x"});
  CHECK(distinct_names({"/x", "/a/x"}) == Names{"_x", "a_x"});
  CHECK(distinct_names({"/a/x", "/a/x/", "/a/../a/x"}) == Names{"x", "x_2", "x_3"});
}

TEST_CASE("BOP scene: numerical order, millimetres to metres, the chosen object") {
  const Folder folder;
  write_bop(folder);
  const Sequence sequence = load_sequence(folder.path(), 9);
  REQUIRE(sequence.truth.size() == 2);
  CHECK(sequence.truth[0].translation().isApprox(Eigen::Vector3d(0.1, -0.05, 0.7505)));  // image 2 before 10
  CHECK(sequence.truth[1].translation().isApprox(Eigen::Vector3d(-0.007, 0.005, 1.0)));
  CHECK(sequence.frames[0].filename() == "000002.png");
  CHECK(sequence.frames[1].filename() == "000010.png");
  CHECK(sequence.visible == std::vector<double>{0.9, 0.5});
  CHECK(sequence.camera.fx == 60);
  CHECK(sequence.camera.fy == 61);
  CHECK(sequence.camera.cx == 31.5);
  CHECK(sequence.camera.cy == 23.5);
  CHECK(sequence.camera.width == 64);
  CHECK(sequence.model_scale == 1e-3);

  const Sequence other = load_sequence(folder.path(), 4);
  CHECK(other.truth[1].linear()(0, 1) == doctest::Approx(-1));  // row-major
  CHECK(other.visible == std::vector<double>{0.8, 0.4});
}

TEST_CASE("BOP scene: bad input") {
  const Folder folder;
  write_bop(folder);
  const auto message = [&](ErrorCode code, std::optional<int> object = 9) {
    return message_of(code, [&] { load_sequence(folder.path(), object); });
  };
  SUBCASE("no object chosen") { CHECK(contains(message(ErrorCode::file, std::nullopt), "--bop-object")); }
  SUBCASE("an object chosen where there are no objects to choose from") {
    const Folder plain;
    write_sequence(plain);
    CHECK(contains(message_of(ErrorCode::file, [&] { load_sequence(plain.path(), 9); }), "no BOP scene"));
  }
  SUBCASE("an object that is not there") {
    CHECK(contains(message(ErrorCode::file, 5), "image 2 has no pose of object 5"));
  }
  SUBCASE("no scene_camera.json") {
    fs::remove(folder / "scene_camera.json");
    CHECK(contains(message(ErrorCode::file), "scene_camera.json"));
  }
  SUBCASE("no scene_gt.json") {
    fs::remove(folder / "scene_gt.json");
    CHECK(contains(message(ErrorCode::file), "scene_gt.json"));
  }
  SUBCASE("cameras for more images than poses") {
    folder.write("scene_camera.json", R"({"2": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1]},
      "10": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1]}, "11": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1]}})");
    const std::string text = message(ErrorCode::file);
    CHECK(contains(text, "3 images"));
    CHECK(contains(text, "2 in scene_gt.json"));
  }
  SUBCASE("an image is missing") {
    fs::remove(folder / "rgb/000010.png");
    CHECK(contains(message(ErrorCode::file), "000010"));
  }
  SUBCASE("not JSON") {
    folder.write("scene_gt.json", "{");
    CHECK(contains(message(ErrorCode::file), "scene_gt.json"));
  }
  SUBCASE("a rotation of eight numbers") {
    folder.write("scene_gt.json", R"({"2": [{"cam_R_m2c": [1,0,0,0,1,0,0,0], "cam_t_m2c": [0,0,1], "obj_id": 9}]})");
    CHECK(contains(message(ErrorCode::file), "cam_R_m2c"));
  }
  SUBCASE("no rotation") {
    folder.write("scene_gt.json", R"({"2": [{"cam_R_m2c": [2,0,0,0,1,0,0,0,1], "cam_t_m2c": [0,0,1], "obj_id": 9}]})");
    CHECK(contains(message(ErrorCode::pose), "image 2"));
  }
  SUBCASE("a camera that changes") {
    folder.write("scene_camera.json", R"({"2": {"cam_K": [60,0,31.5, 0,61,23.5, 0,0,1]},
      "10": {"cam_K": [70,0,31.5, 0,61,23.5, 0,0,1]}})");
    CHECK(contains(message(ErrorCode::file), "another cam_K"));
  }
  SUBCASE("a camera with a skew") {
    folder.write("scene_camera.json", R"({"2": {"cam_K": [60,3,31.5, 0,61,23.5, 0,0,1]},
      "10": {"cam_K": [60,3,31.5, 0,61,23.5, 0,0,1]}})");
    CHECK(contains(message(ErrorCode::file), "skew"));
  }
}

TEST_CASE("occluder use: pixels at least half covered count, and only where the object is") {
  // A row of every class, on the occluder at the left and beside it at the right.
  PixelMask decisions{.width = 14, .height = 2, .classes = std::vector<std::uint8_t>(28)};
  cv::Mat occluder(2, 14, CV_8U, cv::Scalar(0));
  for (int x = 0; x < 14; ++x) {
    decisions.classes[x] = static_cast<std::uint8_t>(x % 7);
    occluder.at<std::uint8_t>(0, x) = x < 7 ? 128 : 127;
    decisions.classes[14 + x] = x < 3 ? 6 : 0;
  }
  const OccluderUse use = occluder_use(decisions, occluder);
  CHECK(use.used == 5);
  CHECK(use.on_occluder == 1);
  CHECK(use.overlaps);

  occluder.row(0).setTo(0);
  occluder.at<std::uint8_t>(1, 13) = 255;  // where the object is not
  CHECK(occluder_use(decisions, occluder).on_occluder == 0);
  CHECK_FALSE(occluder_use(decisions, occluder).overlaps);
  message_of(ErrorCode::image, [&] { occluder_use(decisions, cv::Mat(2, 13, CV_8U, cv::Scalar(0))); });
}

TEST_CASE("occluder masks: seen as the tracker sees frames, without lens distortion") {
  const Folder folder;
  Camera camera{200, 150, 180, 180, 99.5, 74.5, {}};
  cv::Mat recorded(150, 200, CV_8U, cv::Scalar(0));
  camera.distortion = {-0.2, 0.05, 0, 0};
  const Eigen::Vector2d at = camera.distort({20, 30});
  cv::circle(recorded, cv::Point2d(at.x(), at.y()), 4, cv::Scalar(255), cv::FILLED);
  cv::imwrite((folder / "mask.png").string(), recorded);
  const cv::Mat straight = load_occluder_mask(folder / "mask.png", camera);
  CHECK(straight.at<std::uint8_t>(30, 20) == 255);
  const cv::Moments moments = cv::moments(straight);
  CHECK(moments.m10 / moments.m00 == doctest::Approx(20).epsilon(0.03));
  CHECK(moments.m01 / moments.m00 == doctest::Approx(30).epsilon(0.03));
  folder.write("bad.png", "none");
  CHECK(contains(message_of(ErrorCode::file, [&] { load_occluder_mask(folder / "bad.png", camera); }), "bad.png"));
}

TEST_CASE("summary: occluder pixels over the counted frames that an occluder touches") {
  std::vector<FrameRecord> records(5);
  records[0].occluder = OccluderUse{.used = 100, .on_occluder = 10, .overlaps = true};
  records[1].occluder = OccluderUse{.used = 300, .on_occluder = 0, .overlaps = true};
  records[2].occluder = OccluderUse{.used = 999, .on_occluder = 0, .overlaps = false};
  records[3].occluder = OccluderUse{.used = 100, .on_occluder = 100, .overlaps = true};
  records[3].counted = false;
  const Summary summary = summarize(records, tolerance_mm_deg(50, 5));
  REQUIRE(summary.occluder);
  CHECK(summary.occluder->frames == 2);
  CHECK(summary.occluder->share == doctest::Approx(0.025));
  CHECK(summary.occluder->worst_frame == doctest::Approx(0.1));
  CHECK_FALSE(summarize(std::span(records).subspan(2), tolerance_mm_deg(50, 5)).occluder);
}

TEST_CASE("estimated poses: the table of 'holdfast track'") {
  const Folder folder;
  folder.write("poses.csv",
               "frame,time_s,status,tx,ty,tz,qx,qy,qz,qw,ms\n"
               "0,0,held,0,0,0.5,0,0,0,1,2.5\n"
               "2,0.08,lost,0.1,0.2,0.6,0,0,0.70710678,0.70710678,3\n");
  const EstimatedPoses poses = load_estimated_poses(folder / "poses.csv", 30);
  REQUIRE(poses.entries.size() == 2);
  CHECK(poses.entries[1].frame == 2);
  CHECK_FALSE(poses.entries[1].held());
  CHECK(poses.entries[1].result.ms.total == 3);
  CHECK(poses.entries[1].result.T_camera_object.linear()(1, 0) == doctest::Approx(1));  // a quarter turn about z
  CHECK(poses.entries[1].result.T_camera_object.translation().z() == 0.6);

  CHECK(poses.entries[1].result.message.empty());

  folder.write("figures.csv",
               "frame,status,tx,ty,tz,qx,qy,qz,qw,visible,used,residual,correlation,iterations,reason,"
               "texture_holds,contour_holds\n"
               "0,held,0,0,0.5,0,0,0,1,900,300,0.02,0.97,4,\"little texture, \"\"far\"\"\",0,1\n\n"
               "1,held,0,0,0.5,0,0,0,1,800,200,0.03,0.96,5,,1,0\n");
  const EstimatedPoses figures = load_estimated_poses(folder / "figures.csv", 30);
  REQUIRE(figures.entries.size() == 2);
  const FrameResult& first = figures.entries[0].result;
  CHECK(first.visible_pixels() == 900);
  CHECK(first.texture.used_pixels == 300);
  CHECK(first.texture.residual == 0.02);
  CHECK(first.texture.correlation == 0.97);
  CHECK(first.iterations == 4);
  CHECK(first.message == "little texture, \"far\"");
  CHECK_FALSE(first.texture.holds);
  CHECK(first.contour.holds);
  CHECK(figures.entries[1].result.texture.holds);
  CHECK_FALSE(figures.entries[1].result.contour.holds);

  const auto message = [&](ErrorCode code, const std::string& text) {
    folder.write("bad.csv", text);
    return message_of(code, [&] { load_estimated_poses(folder / "bad.csv", 30); });
  };
  const std::string heading = "frame,status,tx,ty,tz,qx,qy,qz,qw\n";
  CHECK(contains(message(ErrorCode::file, "frame,tx,ty,tz\n0,0,0,0\n"), "qx"));
  CHECK(contains(message(ErrorCode::pose, heading + "0,held,0,0,1,0,0,0,0.5\n"), "line 2"));
  CHECK(contains(message(ErrorCode::file, heading + "0,held,0,0,1,0,0,0\n"), "line 2"));
  CHECK(contains(message(ErrorCode::file, heading + "0,held,0,0,x,0,0,0,1\n"), "'x'"));
  CHECK(contains(message(ErrorCode::file, heading + "0,gone,0,0,1,0,0,0,1\n"), "gone"));
  CHECK(contains(message(ErrorCode::file, heading + "1,held,0,0,1,0,0,0,1\n1,held,0,0,1,0,0,0,1\n"), "line 3"));
  CHECK(contains(message(ErrorCode::pose, heading + "0,held,0,0,nan,0,0,0,1\n"), "line 2"));
  CHECK(contains(message(ErrorCode::file, heading), "no poses"));
  CHECK(
      contains(message_of(ErrorCode::file, [&] { load_estimated_poses(folder / "missing.csv", 30); }), "missing.csv"));
}

TEST_CASE("estimated poses: a byte order mark before the table or the lines") {
  const Folder folder;
  const std::string mark = "\xef\xbb\xbf";
  folder.write("t.csv", mark + "frame,tx,ty,tz,qx,qy,qz,qw\n3,0,0,1,0,0,0,1\n");
  const EstimatedPoses table = load_estimated_poses(folder / "t.csv", 30);
  REQUIRE(table.entries.size() == 1);
  CHECK(table.entries[0].frame == 3);
  folder.write("l.txt", mark + "1 0 0 0 0 1 0 0 0 0 1 5\n");
  CHECK(load_estimated_poses(folder / "l.txt", 30).entries.size() == 1);
}

TEST_CASE("estimated poses: TUM's times tell frames, matrices come a line a frame") {
  const Folder folder;
  const auto frames = [&](const std::string& text, std::optional<double> frame_rate) {
    folder.write("poses.tum", text);
    std::vector<int> out;
    for (const auto& entry : load_estimated_poses(folder / "poses.tum", frame_rate).entries) out.push_back(entry.frame);
    return out;
  };
  const std::string pose = " 0 0 0.5 0 0 0 1\n";
  const std::string seconds = "0.033333" + pose + "0.1" + pose + "2.0" + pose;  // as a run that lost frames writes them
  CHECK(frames(seconds, 30) == std::vector<int>{1, 3, 60});
  CHECK(frames(seconds, 60) == std::vector<int>{2, 6, 120});
  CHECK(frames(seconds, std::nullopt) == std::vector<int>{0, 1, 2});
  CHECK(frames("0" + pose + "2" + pose + "5" + pose, 30) == std::vector<int>{0, 2, 5});  // numbers of frames
  CHECK(frames("1 0 0 0 0 1 0 0 0 0 1 0.5\n1 0 0 0 0 1 0 0 0 0 1 0.5\n", 30) == std::vector<int>{0, 1});

  const auto message = [&](const std::string& text) { return message_of(ErrorCode::file, [&] { frames(text, 30); }); };
  CHECK(contains(message("0.05" + pose), "30 frames a second"));
  CHECK(contains(message("1700000000.5" + pose), "counted from the first"));
  CHECK(contains(message("0.1" + pose + "0.1" + pose), "does not come after"));
  CHECK(contains(message("-0.1" + pose), "-0.1"));
}

TEST_CASE("comparison: one estimate a frame, judged as the protocols judge") {
  const Folder folder;
  write_sequence(folder);
  const Sequence sequence = load_sequence(folder.path());
  folder.write("poses.txt", kIdentityAt500 + "0 -1 0 0.1 1 0 0 0.2 0 0 1 0.66\n");
  const EstimatedPoses estimates = load_estimated_poses(folder / "poses.txt", 30);
  const auto records = compare_poses(sequence, estimates, tolerance_mm_deg(50, 5), 0, false);
  REQUIRE(records.size() == 2);
  CHECK_FALSE(records[0].failed);
  CHECK(records[1].failed);
  CHECK(records[1].error.depth() == doctest::Approx(0.06));
  CHECK(records[1].visible == 0.25);
  CHECK(compare_poses(sequence, estimates, tolerance_mm_deg(50, 5), 0.3, false)[1].failed == false);  // not counted

  EstimatedPoses fewer = estimates;
  fewer.entries.erase(fewer.entries.begin());
  const std::string text =
      message_of(ErrorCode::file, [&] { compare_poses(sequence, fewer, tolerance_mm_deg(50, 5), 0, false); });
  CHECK(contains(text, "1 estimated poses"));
  CHECK(contains(text, "2 true poses"));
  CHECK(compare_poses(sequence, fewer, tolerance_mm_deg(50, 5), 0, true).at(0).frame == 1);
  fewer.entries[0].frame = 2;
  message_of(ErrorCode::file, [&] { compare_poses(sequence, fewer, tolerance_mm_deg(50, 5), 0, true); });
}

TEST_CASE("model choice: the longest prefix wins, a path without prefix serves the rest") {
  const Folder folder;
  folder.write("box.obj", "");
  folder.write("a=b.obj", "");
  folder.write("any.obj", "");
  const std::string box = (folder / "box.obj").string();
  const std::string odd = (folder / "a=b.obj").string();
  const std::string any = (folder / "any.obj").string();
  const ModelChoice choice({"box=" + box, any, "box_d=" + odd});
  CHECK(choice.for_sequence("box_a") == box);
  CHECK(choice.for_sequence("box_d_occl") == odd);
  CHECK(choice.for_sequence("bottle") == any);
  CHECK(ModelChoice({odd}).for_sequence("bottle") == odd);  // an existing path, equals sign and all
  CHECK(contains(message_of(ErrorCode::invalid_argument, [&] { ModelChoice({"box=" + box}).for_sequence("cup"); }),
                 "cup"));
  CHECK(contains(message_of(ErrorCode::file, [&] { ModelChoice({"cup=none.obj"}).for_sequence("cup"); }), "none.obj"));
  message_of(ErrorCode::invalid_argument, [] { ModelChoice({"cup="}); });
}

TEST_CASE("evaluate: poses against truth, from the command line to the report") {
  const Folder folder;
  write_sequence(folder);
  folder.write("poses.csv",
               "frame,time_s,status,tx,ty,tz,qx,qy,qz,qw,ms,texture_holds,contour_holds\n"
               "0,0,held,0.003,0.004,0.5,0,0,0,1,2,1,0\n"
               "1,0.04,held,0.1,0.2,0.63,0,0,0.70710678,0.70710678,4,0,1\n");
  folder.write("box.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n");
  const std::string json = (folder / "report.json").string();
  const std::string csv = (folder / "frames.csv").string();
  run_evaluate({folder.path().string(), "--poses", (folder / "poses.csv").string(), "--model",
                (folder / "box.obj").string(), "--json", json, "--csv", csv, "--quiet"});
  std::ifstream in(json);
  const auto report = nlohmann::json::parse(in);
  CHECK(report["protocol"] == "poses");
  const auto& entry = report["evaluations"].at(0);
  CHECK(entry["diameter_mm"].get<double>() == doctest::Approx(100 * std::sqrt(2.0)));
  const auto& summary = entry["summary"];
  CHECK(summary["frames"] == 2);
  CHECK(summary["success"]["share"] == 1.0);
  CHECK(summary["success"]["first_beyond"].is_null());
  CHECK(summary["within_20mm_2deg"]["share"] == 0.5);
  CHECK(summary["within_20mm_2deg"]["first_beyond"] == 1);
  CHECK(summary["translation_mm"]["median"].get<double>() == doctest::Approx(17.5));
  CHECK(summary["depth_mm"]["max"].get<double>() == doctest::Approx(30));
  CHECK(summary["lateral_mm"]["max"].get<double>() == doctest::Approx(5));
  CHECK(summary["add"]["mm"]["max"].get<double>() == doctest::Approx(30));  // a shift: every point's distance
  CHECK(summary["add"]["below_5_percent"] == 0.5);
  CHECK(summary["confidently_wrong_frames"] == 1);
  CHECK(summary["coverage"]["inside_95"].is_null());  // the table reports no covariance
  CHECK(summary["ms_median"] == 3.0);
  CHECK(entry["per_frame"]["z_mm"].at(1).get<double>() == doctest::Approx(30));
  CHECK(entry["per_frame"]["texture_holds"] == nlohmann::json::parse("[true, false]"));
  CHECK(entry["per_frame"]["contour_holds"] == nlohmann::json::parse("[false, true]"));

  std::ifstream table(csv);
  std::string line;
  std::vector<std::size_t> columns;
  while (std::getline(table, line)) {
    for (const char* name :
         {",texture_holds,contour_holds,snapshot_holds,", ",contour_lines,", ",contour_near_lines,", ",contour_score,",
          ",contour_residual,", ",edge_lines,edge_near_lines,", ",edge_score,edge_residual,", ",ms_contour,"}) {
      CHECK(contains(line, name) == columns.empty());
    }
    columns.push_back(static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')));
  }
  REQUIRE(columns.size() == 3);
  CHECK(columns[1] == columns[0]);
  CHECK(columns[2] == columns[0]);
}

TEST_CASE("evaluate: two files of poses need no folder") {
  const Folder folder;
  folder.write("truth.txt", kIdentityAt500 + kTurnedAt600);
  folder.write("estimate.txt", kIdentityAt500 + kTurnedAt600);
  run_evaluate({"--poses", (folder / "estimate.txt").string(), "--truth", (folder / "truth.txt").string(), "--json",
                (folder / "report.json").string()});
  std::ifstream in(folder / "report.json");
  const auto report = nlohmann::json::parse(in);
  CHECK(report["evaluations"].at(0)["sequence"] == "truth");
  CHECK(report["evaluations"].at(0)["summary"]["translation_mm"]["max"] == 0.0);
  CHECK(report["evaluations"].at(0)["summary"]["add"].is_null());
}

TEST_CASE("evaluate: what is missing or cannot be is said before any work") {
  const Folder folder;
  write_sequence(folder);
  const std::string sequence = folder.path().string();
  const auto message = [](ErrorCode code, const std::vector<std::string>& arguments) {
    return message_of(code, [&] { run_evaluate(arguments); });
  };
  CHECK(contains(message(ErrorCode::invalid_argument, {}), "no sequence"));
  CHECK(contains(message(ErrorCode::invalid_argument, {sequence}), "--model"));
  CHECK(contains(message(ErrorCode::file, {sequence, "--model", "no_such.obj"}), "no_such.obj"));
  CHECK(contains(message(ErrorCode::invalid_argument, {"--poses", "x.txt"}), "--truth"));
  folder.write("box.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  CHECK(contains(message(ErrorCode::output, {sequence, "--model", (folder / "box.obj").string(), "--json",
                                             (folder / "no_folder/report.json").string()}),
                 "report.json"));
  CHECK_THROWS_AS(run_evaluate({sequence, "--step", "0"}), CLI::ParseError);
  CHECK_THROWS_AS(run_evaluate({sequence, "--protocol", "mine"}), CLI::ParseError);
}

TEST_CASE("plots: a missing python or matplotlib is said, with what to install") {
  CHECK(
      contains(message_of(ErrorCode::invalid_argument, [] { require_plotting("no-such-python"); }), "no-such-python"));
  const std::string text = message_of(ErrorCode::invalid_argument, [] { require_plotting("false"); });
  CHECK(contains(text, "python3-matplotlib"));
  CHECK(contains(message_of(ErrorCode::output, [] { draw_plots("report.json", "folder", "false"); }), "folder"));
}

TEST_CASE("plots: drawn from a report") {
  try {
    require_plotting();
  } catch (const Error& error) {
    MESSAGE("not drawn here: ", error.what());
    return;
  }
  const Folder folder;
  Evaluation evaluation;
  evaluation.sequence = "some";
  evaluation.diameter = 0.1;
  for (int i = 0; i < 20; ++i) {
    FrameRecord record;
    record.frame = i;
    record.result.status = i == 7 ? Status::lost : Status::held;
    record.counted = i != 8;
    record.visible = i == 8 ? 0.1 : 1;
    record.result.T_camera_object.translation().x() = i == 7 ? std::nan("") : 0.001 * i;
    record.error = pose_error(record.T_camera_object_true, record.result.T_camera_object);
    record.add = record.add_s = record.error.distance();
    evaluation.records.push_back(record);
  }
  evaluation.summary = summarize(evaluation.records, tolerance_mm_deg(50, 5), evaluation.diameter);
  write_json(folder / "report.json", {.protocol = "poses"}, {evaluation});
  draw_plots(folder / "report.json", folder.path());
  for (const char* name : {"some_step1.png", "accuracy.png"}) {
    const cv::Mat image = cv::imread((folder / name).string());
    REQUIRE_FALSE(image.empty());
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    CHECK(deviation[0] > 5);  // something is drawn
  }
}
