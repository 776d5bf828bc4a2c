// What people hand to the program that is not quite what it was made for: other kinds of pictures give the same poses,
// and what cannot work is said in a line that names the cause.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
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

constexpr int kFrames = 2;

/// A short sequence, its model's parts, and whatever else a test writes there.
class Inputs {
 public:
  Inputs() {
    truth_ = write_small_sequence(folder_, kFrames);
    obj_ = read_file(folder_ / "box.obj");
  }

  const TemporaryFolder& folder() const { return folder_; }
  const Pose& last_truth() const { return truth_.back(); }
  const std::string& obj() const { return obj_; }
  ProgramRun run(const Arguments& arguments) const { return run_holdfast(arguments, folder_); }

 private:
  TemporaryFolder folder_;
  std::vector<Pose> truth_;
  std::string obj_;
};

const Inputs& inputs() {
  static const Inputs made;
  return made;
}

void write(const std::string& name, const std::string& text) { inputs().folder().write(name, text); }

Arguments track(const std::string& input = "frames", const std::string& model = "box.obj",
                const std::string& camera = "camera.yml", const std::string& init = "first.txt") {
  return {"track", input, "--model", model, "--camera", camera, "--init", init, "--poses", "poses.csv", "--quiet"};
}

void check_fails(int exit_code, const Arguments& arguments, const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& argument : arguments) command += argument + " ";
  CAPTURE(command);
  check_error(inputs().run(arguments), exit_code, words);
}

/// The frames with `change` made to each, as `folder`.
void write_frames(const std::string& folder, const std::string& extension,
                  const std::function<cv::Mat(const cv::Mat&)>& change) {
  fs::create_directory(inputs().folder() / folder);
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = std::to_string(i);
    const cv::Mat frame = cv::imread((inputs().folder() / ("frames/" + name + ".png")).string());
    cv::imwrite((inputs().folder() / (folder + "/" + name + extension)).string(), change(frame));
  }
}

/// Millimetres that the last frame's translation is off the truth; held, and nothing on stderr.
double tracked_error(const Arguments& arguments) {
  const ProgramRun run = inputs().run(arguments);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.empty());
  std::string table = read_file(inputs().folder() / "poses.csv");
  table.pop_back();
  std::istringstream row(table.substr(table.rfind('\n') + 1));
  std::vector<std::string> cells;
  for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
  REQUIRE(cells.size() > 9);
  CHECK(cells[2] == "held");
  const Eigen::Vector3d found(std::stod(cells[3]), std::stod(cells[4]), std::stod(cells[5]));
  return 1e3 * (found - inputs().last_truth().translation()).norm();
}

cv::Mat sixteen_bits(const cv::Mat& frame, double factor) {
  cv::Mat wide;
  frame.convertTo(wide, CV_16U, factor);
  return wide;
}

cv::Mat grey(const cv::Mat& frame) {
  cv::Mat out;
  cv::cvtColor(frame, out, cv::COLOR_BGR2GRAY);
  return out;
}

}  // namespace

TEST_CASE("Pictures with alpha, in grey, of 16 bits, of other formats, beside other files: held all the same") {
  write_frames("alpha", ".png", [](const cv::Mat& frame) {
    cv::Mat out;
    cv::cvtColor(frame, out, cv::COLOR_BGR2BGRA);
    cv::insertChannel(cv::Mat(frame.size(), CV_8U, cv::Scalar(0)), out, 3);
    return out;
  });
  write_frames("wide", ".png", [](const cv::Mat& frame) { return sixteen_bits(frame, 257); });
  write_frames("grey", ".png", grey);
  write_frames("widegrey", ".tif", [](const cv::Mat& frame) { return sixteen_bits(grey(frame), 257); });
  write_frames("webp", ".webp", [](const cv::Mat& frame) { return frame; });
  write_frames("capitals", ".PNG", [](const cv::Mat& frame) { return frame; });
  write("capitals/notes.txt", "not a picture");
  const double usual = tracked_error(track());
  CHECK(usual < 1);
  for (const std::string folder : {"alpha", "wide", "capitals"}) {
    CAPTURE(folder);
    CHECK(tracked_error(track(folder)) == usual);
  }
  for (const std::string folder : {"grey", "widegrey", "webp"}) {
    CAPTURE(folder);
    CHECK(tracked_error(track(folder)) < 2);
  }
  CHECK(tracked_error(track("frames/*.png")) == usual);
}

TEST_CASE("Nearly black frames, such as 12 bits in 16, are warned of") {
  write_frames("twelve", ".png", [](const cv::Mat& frame) { return sixteen_bits(frame, 16); });
  for (const Arguments& arguments :
       {track("twelve"), Arguments{"bake", "twelve", "--model", "box.obj", "--camera", "camera.yml", "--init",
                                   "first.txt", "--out", "black.obj", "--quiet"}}) {
    const ProgramRun run = inputs().run(arguments);
    CHECK(run.exit_code == kOk);
    CHECK(run.err.starts_with("holdfast: warning: frame 0 ('twelve/0.png') is nearly black"));
    CHECK(run.err.find("12 bits in 16") != std::string::npos);
  }
}

TEST_CASE("Inputs that are nearly right") {
  fs::create_directory(inputs().folder() / "recording");
  fs::copy(inputs().folder() / "frames", inputs().folder() / "recording/left");
  check_fails(kInput, track("recording"), {"no image files", "'recording/left'", "give that"});
  write("empty.mp4", "");
  check_fails(kInput, track("empty.mp4"), {"empty.mp4", "it is empty"});
  check_fails(kInput, track("http://127.0.0.1:9/none.mp4"), {"none.mp4", "cannot be reached"});
  fs::create_directory(inputs().folder() / "spoiled");
  write("spoiled/0.png", "no picture");
  const ProgramRun run = inputs().run(track("spoiled"));
  check_error(run, kInput, {"spoiled/0.png", "replace the file"});
  CHECK(run.err.find("--stop") == std::string::npos);  // there is nothing before it
  cv::imwrite((inputs().folder() / "dot.png").string(), cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(200)));
  write("four.txt", "325 325 159.5 119.5\n");
  check_fails(kInput, track("dot.png", "box.obj", "four.txt"), {"out of the picture of 1x1 pixels"});
}

TEST_CASE("Models that are nearly right") {
  std::string text = inputs().obj();
  text.replace(text.find("box.mtl"), 7, "gone.mtl");
  write("no_material.obj", text);
  check_fails(kInput, track("frames", "no_material.obj"), {"no_material.obj", "'gone.mtl'", "holdfast bake"});
  check_fails(kInput, {"simulate", "--report", "--frames", "2", "--model", "no_material.obj"}, {"'gone.mtl'"});
  write("lines.obj", "v 0 0 0\nv 0.1 0 0\nv 0.2 0 0\nf 1 2 3\nf 1 1 2\n");
  check_fails(kInput, track("frames", "lines.obj"), {"lines.obj", "no triangle with an area"});
  // Some without area harm nothing.
  write("some.obj", inputs().obj() + "f 1/1 1/1 2/2\nf 1/1 2/2 2/2\n");
  CHECK(tracked_error(track("frames", "some.obj")) < 1);

  Mesh large = io::load_model(inputs().folder() / "box.obj");
  for (Eigen::Vector3f& position : large.positions) position *= 1000;
  io::save_model(inputs().folder() / "millimetres.obj", large);
  const ProgramRun run = inputs().run({"simulate", "huge", "--frames", "1", "--size", "64x48", "--samples", "1",
                                       "--quiet", "--model", "millimetres.obj"});
  CHECK(run.exit_code == kOk);
  CHECK(run.err.find("--model-scale 0.001") != std::string::npos);
  Arguments scaled = track("frames", "millimetres.obj");
  scaled.insert(scaled.end(), {"--model-scale", "0.001"});
  CHECK(tracked_error(scaled) < 1);
}

TEST_CASE("A focal length in millimetres is warned of") {
  write("lens.txt", "4.2 4.2 159.5 119.5\n");
  const ProgramRun run = inputs().run(track("frames", "box.obj", "lens.txt"));
  CHECK(run.err.find("focal length is 4.2 pixels, far too short for frames of 320x240: is it in millimetres") !=
        std::string::npos);
  // The widest lens that shows straight lines as such, as good as: 150 degrees.
  write("wide.txt", "43 43 159.5 119.5\n");
  CHECK(inputs().run(track("frames", "box.obj", "wide.txt")).err.find("millimetres") == std::string::npos);
}

TEST_CASE("Frames of a fisheye are followed as well as a pinhole's") {
  const cv::Matx33d K(kSmallCamera.fx, 0, kSmallCamera.cx, 0, kSmallCamera.fy, kSmallCamera.cy, 0, 0, 1);
  const cv::Vec4d lens(0.05, -0.02, 0.01, 0);
  std::vector<cv::Point2d> recorded, ideal;
  for (int y = 0; y < kSmallCamera.height; ++y) {
    for (int x = 0; x < kSmallCamera.width; ++x) recorded.emplace_back(x, y);
  }
  cv::fisheye::undistortPoints(recorded, ideal, K, lens, cv::noArray(), K);
  cv::Mat map;
  cv::Mat(ideal).reshape(2, kSmallCamera.height).convertTo(map, CV_32FC2);
  write_frames("fisheye", ".png", [&map](const cv::Mat& frame) {
    cv::Mat out;
    cv::remap(frame, out, map, cv::noArray(), cv::INTER_CUBIC);
    return out;
  });
  const auto camera = [](const std::string& model) {
    return "image_width: 320\nimage_height: 240\n" + model +
           "\ncamera_matrix: [325, 0, 159.5, 0, 325, 119.5, 0, 0, 1]\ndistortion_coefficients: [0.05, -0.02, 0.01, "
           "0]\n";
  };
  write("fisheye.yaml", camera("camera_model: fisheye"));
  CHECK(tracked_error(track("fisheye", "box.obj", "fisheye.yaml")) < 1);
}

TEST_CASE("Calibrations whose first pixel's centre is at a half") {
  write("half.txt", "325 325 160 120\n");
  Arguments arguments = track("frames", "box.obj", "half.txt");
  const double beside = tracked_error(arguments);
  arguments.insert(arguments.end(), {"--pixel-centres", "0.5"});
  const double right = tracked_error(arguments);
  CHECK(right == doctest::Approx(tracked_error(track())));
  CHECK(right < beside);
}

TEST_CASE("Options that do nothing for a plain model, points beside the model") {
  write("plain.obj",
        "v -.1 -.075 -.04\nv .1 -.075 -.04\nv .1 .075 -.04\nv -.1 .075 -.04\nv 0 0 .1\nf 1 3 2\nf 1 4 3\n"
        "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
  for (const char* option : {"--search-radius=16", "--angle-maximum=0.3", "--no-gradient-test", "--views=none.views"}) {
    Arguments arguments = track("frames", "plain.obj");
    arguments.push_back(option);
    check_fails(kUsage, arguments, {"no effect", "texture"});
  }
  const Pose first = io::load_pose(inputs().folder() / "first.txt");
  std::string on, off, millimetres;  // the corners as they are, with another axis up, in another unit
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p(i & 1 ? 0.1 : -0.1, i & 2 ? 0.075 : -0.075, i & 4 ? 0.04 : -0.04);
    const Eigen::Vector2d pixel = kSmallCamera.project(first * p);
    const std::string seen = "," + std::to_string(pixel.x()) + "," + std::to_string(pixel.y()) + "\n";
    on += std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z()) + seen;
    off += std::to_string(p.x()) + "," + std::to_string(-p.z()) + "," + std::to_string(p.y()) + seen;
    millimetres += fmt::format("{},{},{}{}", 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z(), seen);
  }
  write("on.csv", on);
  write("off.csv", off);
  write("millimetres.csv", millimetres);
  const auto init = [](const char* points) {
    return inputs().run({"init", "--points", points, "--model", "box.obj", "--camera", "camera.yml"});
  };
  CHECK(init("on.csv").err.empty());
  const ProgramRun beside = init("off.csv");
  CHECK(beside.exit_code == kOk);
  CHECK(beside.err.find("do not lie on the model") != std::string::npos);
  const std::string other_unit = init("millimetres.csv").err;
  CHECK(other_unit.find("the points spread over 262 m and the model over 0.262 m") != std::string::npos);
  CHECK(other_unit.find("--model-scale") == std::string::npos);
}

TEST_CASE("A frame that a decoder stumbles over is told in one line") {
  write("short.ppm", "P6 320 240 255\n" + std::string(99, '\0'));
  std::string png = read_file(inputs().folder() / "frames/0.png");
  png[png.size() / 2] = static_cast<char>(png[png.size() / 2] ^ 1);
  write("flipped.png", png);
  for (const char* name : {"short.ppm", "flipped.png"}) {
    CAPTURE(name);
    const ProgramRun run = inputs().run(track(name));
    CHECK(run.exit_code == kInput);
    CHECK(run.err.starts_with("holdfast: error: cannot read frame 0, '" + std::string(name)));
    CHECK(std::count(run.err.begin(), run.err.end(), '\n') == 1);
  }
}

TEST_CASE("An overlay in .avi that a kill cuts off can be played as far as it goes") {
  const cv::Mat frame = cv::imread((inputs().folder() / "frames/0.png").string());
  constexpr int kLong = 900, kKilledAt = 60;
  cv::VideoWriter video((inputs().folder() / "long.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30,
                        frame.size());
  REQUIRE(video.isOpened());
  for (int i = 0; i < kLong; ++i) video.write(frame);
  video.release();
  std::string command = "'" + program_path() + "'";
  for (const std::string& argument : track("long.avi")) command += " " + argument;
  command += " --overlay cut.avi & child=$!; until [ $(wc -l <poses.csv) -gt " + std::to_string(kKilledAt) +
             " ] || ! kill -0 $child; do sleep 0.02; done; kill -9 $child; wait $child";
  fs::remove(inputs().folder() / "poses.csv");
  write("poses.csv", "");
  CHECK(run_program("/bin/sh", {"-c", command}, inputs().folder().path()).exit_code == 128 + 9);
  CHECK_FALSE(fs::exists(inputs().folder() / "cut.avi"));
  cv::VideoCapture cut((inputs().folder() / "cut.part.avi").string(), cv::CAP_FFMPEG);
  REQUIRE(cut.isOpened());
  int frames = 0;
  for (cv::Mat picture; cut.read(picture);) ++frames;
  CHECK(frames >= kKilledAt / 4);  // frames wait in line to be drawn and written
  CHECK(frames < kLong);
}

TEST_CASE("Text files of Windows") {
  const std::string mark = "\xef\xbb\xbf";
  write("marked_camera.txt", mark + "325 325 159.5 119.5\r\n");
  const std::string pose = read_file(inputs().folder() / "first.txt");
  write("marked_pose.txt", mark + pose);
  CHECK(tracked_error(track("frames", "box.obj", "marked_camera.txt", "marked_pose.txt")) < 1);
  write("marked.csv", mark + "x,y,z,u,v\r\n0,0,0,10,10\r\n.1,0,0,20,10\r\n.2,.1,0,30,10\r\n");
  const auto init = [](const std::string& points) {
    return Arguments{"init", "--camera", "camera.yml", "--points", points};
  };
  check_fails(kInput, init("marked.csv"), {"3 different points"});  // all three lines were read
  write("commas.csv", "0;0;0;10,5;10\n");
  check_fails(kInput, init("commas.csv"), {"commas.csv", "6 columns", "decimal points"});
}

TEST_CASE("A dash is no file") {
  Arguments arguments = track();
  arguments.insert(arguments.end(), {"--tum", "-"});
  check_fails(kOutput, arguments, {"'-'", "/dev/stdout"});
  CHECK_FALSE(fs::exists(inputs().folder() / "-"));
  arguments.back() = "/dev/stdout";
  CHECK(inputs().run(arguments).out.starts_with("0"));
}

TEST_CASE("A trajectory that never shows the object") {
  const std::string far = "1 0 0 900 0 1 0 0 0 0 1 600\n";  // millimetres
  write("far.txt", far + far);
  const ProgramRun run = inputs().run({"simulate", "unseen", "--trajectory", "far.txt"});
  CHECK(run.exit_code == kOk);
  CHECK(
      run.err.find("warning: the object is in no frame; are the poses of --trajectory object to camera, in metres?") !=
      std::string::npos);
}
